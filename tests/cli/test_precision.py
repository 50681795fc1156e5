"""`platform-daemon predict`: the Cramer-Rao bound of a plan."""

import json

import pytest

from tests.kit.command_line import here


def test_predict_gives_the_bound_for_each_window(tmp_path):
    done = here("predict", "--resonator", "thread", "--window", "n50", "--window", "4.9", "--json", tmp_path / "p.json")
    assert done.returncode == 0, done.stderr
    short, long = json.loads((tmp_path / "p.json").read_text())["windows"]
    assert short["std"]["f_nat_hz"] == pytest.approx(0.0008, rel=0.15)
    assert long["std"]["f_nat_hz"] == pytest.approx(1.7e-5, rel=0.1)
