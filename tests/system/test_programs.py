"""The programs behind `make`."""

import re
import runpy
import sys

import pytest

from tests.kit.data import ROOT

MAKEFILE = ROOT / "Makefile"
PROGRAMS = sorted(set(re.findall(r"-m (tests\.[\w.]+)", MAKEFILE.read_text())))


def test_the_makefile_runs_programs_of_the_tests():
    assert {
        "tests.campaigns.accuracy",
        "tests.campaigns.estimator_statistics",
        "tests.campaigns.faults.campaign",
    } <= set(PROGRAMS)


@pytest.mark.parametrize("name", PROGRAMS)
def test_every_program_of_the_makefile_says_what_it_does_and_takes(name, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", [name, "--help"])
    monkeypatch.delitem(sys.modules, name, raising=False)
    with pytest.raises(SystemExit) as end:
        runpy.run_module(name, run_name="__main__")  # as python -m does
    assert end.value.code in (0, None)
    said = capsys.readouterr().out
    assert "usage:" in said.lower()
    assert said.count("--") > 1
