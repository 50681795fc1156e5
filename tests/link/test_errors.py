"""Errors that cross the socket between processes that know different classes."""

from drivers.errors import InputError, PlatformError
from platform_daemon.link.errors import error_from_wire, error_on_wire
from platform_daemon.schemas import LinkError


def test_an_error_is_of_the_nearest_class_that_the_other_process_knows():
    class Unheard(InputError):
        title = "Unheard of"

    told = error_on_wire(Unheard("no such thing", where="here", why="never", remedy="look"))
    assert told.kinds == ("Unheard", "InputError", "PlatformError")
    there = error_from_wire(told)
    assert type(there) is Unheard
    elsewhere = error_from_wire(LinkError.model_validate({**told.model_dump(), "kinds": ("Stranger", *told.kinds[1:])}))
    assert type(elsewhere) is InputError  # so that it ends a command with 2, as here
    assert (elsewhere.title, str(elsewhere)) == ("Unheard of", str(there))


def test_what_nobody_foresaw_is_named():
    told = error_on_wire(ZeroDivisionError("by zero"))
    assert type(error_from_wire(told)) is PlatformError
    assert "ZeroDivisionError" in told.what
