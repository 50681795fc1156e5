"""What the program writes and answers is what the golden files of `python -m tests.system.golden` say."""

import json
import re
import subprocess

import pytest
import typer.testing

from platform_daemon.cli.main import app
from tests.system.golden.comparison import differences, values
from tests.system.golden.scenarios import SCENARIOS, make
from tests.system.golden.volatile import Placeholders
from tests.system.golden.workplace import DATA, Workplace

GOLDEN = DATA / "golden"
QUICK = {"rest-faults": (pytest.mark.long,), "cli-design": (pytest.mark.long,)}
"""Of the others each takes a minute; every route and command has its own tests."""


@pytest.mark.parametrize(
    "scenario", [pytest.param(name, marks=QUICK.get(name, pytest.mark.campaign)) for name in SCENARIOS]
)
def test_the_program_tells_what_it_told(scenario, tmp_path):
    make(tmp_path, [scenario])
    assert not differences(GOLDEN / scenario, tmp_path / scenario, exact=False)


NOT_ALONE = {
    "serve",
    "openapi",
    "emulate",
    "schedule",
    "doctor",
    "outputs-off",
    "reset-fault",
    "trend",
    "index",
    "retention",
    "reproduce",
    "budget",
    "measurand",
    "certificate",
}
"""They run for ever or for long, need another program or many recordings, or tell what this computer is; they have own
tests."""


def test_every_command_has_a_case():
    first_lines = [path.read_text().partition("\n")[0].split() for path in GOLDEN.glob("cli-*/*.txt")]
    met = {word for line in first_lines for word in line[2:] if line[0] == "$"} | NOT_ALONE
    asked = {name for group in ((), *GROUPS) for name in _commands(*group)}
    assert {"fit", "show", "receive", "serve"} < asked
    assert asked <= met


GROUPS = (("config",), ("bench",), ("calibrate",), ("models",), ("token",))


def _commands(*group):
    environment = {"COLUMNS": "120", "TERM": "dumb", "NO_COLOR": "1"}
    told = typer.testing.CliRunner().invoke(app, [*group, "--help"], env=environment).output
    panel = told.partition("─ Commands ─")[2]
    return re.findall(r"^│ (\S+)", panel, re.MULTILINE)


@pytest.mark.parametrize(
    ("now", "word"),
    [
        ('{"b": 1, "a": [1.0, "x"]}', "order"),
        ('{"a": [1.0, "x"]}', "lost"),
        ('{"a": [1.0, "x"], "b": 1.0}', "/b"),
        ('{"a": [1.00001, "x"], "b": 1}', "/a/0"),
        ('{"a": [1, "x"], "b": 1}', "/a/0"),
        ('{"a": [1.0, "y"], "b": 1}', "/a/1"),
        ('{"a": [1.0], "b": 1}', "/a"),
    ],
)
def test_a_change_is_found_and_pointed_at(now, word):
    (found,) = values(json.loads('{"a": [1.0, "x"], "b": 1}'), json.loads(now))
    assert word in found


def test_only_rounding_may_differ_on_another_computer(tmp_path):
    for name, text in (("was", '{"a": 1.0, "s": "0.50 of 7"}'), ("now", '{"a":1.0000000001, "s": "0.51 of 7"}')):
        (tmp_path / name).mkdir()
        (tmp_path / name / "x.json").write_text(text)
    assert not differences(tmp_path / "was", tmp_path / "now", exact=False)
    assert len(differences(tmp_path / "was", tmp_path / "now", exact=True)) == 2
    (tmp_path / "now/x.json").write_text('{"a":1.0, "s": "0.50 of 8"}')
    assert differences(tmp_path / "was", tmp_path / "now", exact=False)


def test_the_form_of_the_text_counts_on_the_same_computer(tmp_path):
    for name, text in (("was", '{"a": 1e-06}'), ("now", '{"a": 1e-6}')):
        (tmp_path / name).mkdir()
        (tmp_path / name / "x.json").write_text(text)
    (found,) = differences(tmp_path / "was", tmp_path / "now", exact=True)
    assert "another text" in found


def test_what_is_volatile_keeps_its_type_and_what_is_not_stays(tmp_path):
    clean = Placeholders({tmp_path: "<folder>"}, "1.2.3").clean
    assert clean('"seconds": 0.25') == '"seconds": "<float>"'
    assert clean('"samples": 10, "seconds": 0.25') == '"samples": 10, "seconds": 0.25'
    assert clean('"2001-02-03T04:05:06Z"') == '"2001-02-03T04:05:06Z"'
    assert clean(f"{tmp_path}/x") == "<folder>/x"
    first, other = "fit-20260101T000000-abc123", "fit-20260101T000001-abc124"
    assert clean(f"{other} {first} {other}") == "fit-<1> fit-<2> fit-<1>"


def test_a_command_that_does_not_end_as_it_did_is_found(tmp_path):
    place = Workplace(tmp_path / "work", tmp_path / "kept")
    place.case("bad", "fit", "missing.h5")
    text = (tmp_path / "kept/bad.txt").read_text()
    assert "exit code 2" in text
    assert "missing.h5: no such file" in text


def test_the_list_of_differences_ends_with_exit_code_1(tmp_path):
    for name, text in (("was", "1"), ("now", "2")):
        (tmp_path / name / "cli-bad").mkdir(parents=True)
        (tmp_path / name / "cli-bad" / "x.json").write_text(text)
    place = Workplace(tmp_path / "work", tmp_path / "kept")
    program = [*place.command()[:2], "tests.system.golden", "compare", tmp_path / "was", "--with", tmp_path / "now"]
    done = subprocess.run(
        [*program, "--only", "cli-bad"], capture_output=True, text=True, check=False, cwd=place.tree, timeout=60
    )
    assert done.returncode == 1
    assert done.stdout == "cli-bad/x.json#: was 1, is 2\n"
