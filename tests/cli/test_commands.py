"""The list of commands, what their help may load, and the options that are derived from the models of requests."""

import json
import subprocess
import sys

import pytest

from platform_daemon.cli.main import UNLISTED, commands, load
from platform_daemon.core.command_line.request_fields import REQUEST_FIELDS
from platform_daemon.core.command_line.request_options import offers
from platform_daemon.core.schemas.access import Role
from tests.kit import request_fields
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.command_words import all_words

HEAVY = (
    "asyncio",
    "fastapi",
    "h5py",
    "httpx2",
    "importlib.metadata",
    "matplotlib",
    "multiprocessing",
    "numba",
    "numpy",
    "platform_daemon.core.hardware",
    "platform_daemon.estimation",
    "platform_daemon.processes",
    "pydantic",
    "rich.progress",
    "scipy",
    "structlog",
)
# A feature's folder names what it offers; only its commands, and options that several of them share, may be loaded.
FEATURE_AT_WORK = r"platform_daemon\.features\.\w+\.(?!(\w+_)?command$|drive_options$|options$)"
PROBE = f"""
import json, re, sys
from platform_daemon.__main__ import main
loaded = {{}}
for words in json.loads(sys.argv[1]):
    sys.argv = ["platform-daemon", *words, "--help"]
    try:
        main()
    except SystemExit as end:
        assert not end.code, words
    at_work = [name for name in sys.modules if re.match({FEATURE_AT_WORK!r}, name)]
    loaded[" ".join(words)] = [*(name for name in {HEAVY!r} if name in sys.modules), *at_work]
sys.stderr.write(json.dumps(loaded))
"""


def test_the_help_of_no_command_loads_what_takes_long():
    words = all_words()
    assert len(words) > 50
    done = subprocess.run(
        [sys.executable, "-c", PROBE, json.dumps(words)], capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    loaded = json.loads(done.stderr)
    assert len(loaded) == len(words)
    assert {name: modules for name, modules in loaded.items() if modules} == {}


@pytest.mark.parametrize("name", commands() | UNLISTED)
def test_the_list_of_commands_says_what_the_help_of_each_command_says(name):
    entry = (commands() | UNLISTED)[name]
    first = (load(name).help or "").split("\n\n")[0]
    assert entry.help.split() == first.split()


def test_the_table_of_fields_is_what_the_models_of_the_requests_say():
    assert request_fields.tables() == REQUEST_FIELDS, "run `python -m tests.kit.request_fields`"


def test_a_field_in_tesla_is_offered_in_microtesla_with_its_limits_and_default():
    (offered,) = offers("RampRequest", "step_ut")
    option = offered.parameter
    assert (offered.key, offered.flag, option.default) == ("step_t", "--step-ut", 10.0)
    assert "uT" in option.annotation.__metadata__[0].help
    assert "[0.001<=x<=1000]" in option.annotation.__metadata__[0].help
    assert offered.value(20.0) == pytest.approx(2e-5)


def test_what_is_not_given_is_not_in_the_request():
    found = {each.name: each.parameter.default for each in offers("AcquisitionRequest", "shots", "sequence.rx_s")}
    assert found == {"shots": 1, "rx_s": None}


def test_a_number_outside_the_limits_of_its_field_is_refused_in_the_words_of_the_option(tmp_path):
    done = here("ramp", "--resonator", "jewel", "--most-shots", "0", "--out", tmp_path / "r.h5")
    assert_one_line_error(done, 2, "--most-shots", "1<=x<=100")
    assert_one_line_error(
        here("ramp", "--resonator", "jewel", "--overdose-rate", "0.6"), 2, "overdose_rate", "below 0.5"
    )


def test_a_word_that_is_nearly_a_command_is_named():
    assert_one_line_error(here("mesure"), 2, "'measure'")


def test_the_roles_that_a_token_may_have_are_those_of_the_interface():
    assert [role.value for role in Role] == ["viewer", "operator", "admin"]


def test_the_schema_of_the_rest_interface_is_printed_without_a_server():
    done = here("openapi")
    assert done.returncode == 0
    assert json.loads(done.stdout)["info"]["title"] == "platform-daemon"
