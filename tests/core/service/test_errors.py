"""Errors that cross the socket between processes that know different classes."""

import subprocess
import sys

from drivers.errors import InputError, PlatformError
from platform_daemon.core.schemas.rpc import RpcError
from platform_daemon.core.service.errors import error_from_wire, error_on_wire


def test_an_error_is_of_the_nearest_class_that_the_other_process_knows():
    class Unheard(InputError):
        title = "Unheard of"

    told = error_on_wire(Unheard("no such thing", where="here", why="never", remedy="look"))
    assert told.kinds == ("Unheard", "InputError", "PlatformError")
    there = error_from_wire(told)
    assert type(there) is Unheard
    elsewhere = error_from_wire(RpcError.model_validate({**told.model_dump(), "kinds": ("Stranger", *told.kinds[1:])}))
    assert type(elsewhere) is InputError  # so that it ends a command with 2, as here
    assert (elsewhere.title, str(elsewhere)) == ("Unheard of", str(there))


def test_an_error_of_a_feature_keeps_its_class_in_a_process_that_has_not_loaded_the_feature():
    told = RpcError(
        kinds=("UnknownSchedule", "InputError", "PlatformError"),
        title="Unknown schedule",
        what="no such schedule",
        where="schedule-1",
        why="",
        remedy="look at the list",
    )
    program = (
        "import sys\n"
        "from platform_daemon.core.schemas.rpc import RpcError\n"
        "from platform_daemon.core.service.errors import error_from_wire\n"
        "error = error_from_wire(RpcError.model_validate_json(sys.argv[1]))\n"
        "print(type(error).__name__, error.http_status)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, told.model_dump_json()], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["UnknownSchedule", "404"]


def test_what_nobody_foresaw_is_named():
    told = error_on_wire(ZeroDivisionError("by zero"))
    assert type(error_from_wire(told)) is PlatformError
    assert "ZeroDivisionError" in told.what
