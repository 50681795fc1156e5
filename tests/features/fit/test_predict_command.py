"""`platform-daemon predict`: the Cramer-Rao bound of a plan."""

import json

import pytest

from tests.kit.command_line import assert_one_line_error, here

TERM = ("predict", "--resonator", "jewel", "--with-term", "quadratic_drag", "--expect", "quadratic_drag_per_rad=1e-4")


def test_predict_gives_the_bound_for_each_window(tmp_path):
    done = here("predict", "--resonator", "thread", "--window", "n50", "--window", "4.9", "--json", tmp_path / "p.json")
    assert done.returncode == 0, done.stderr
    short, long = json.loads((tmp_path / "p.json").read_text())["windows"]
    assert short["std"]["f_nat_hz"] == pytest.approx(0.0008, rel=0.15)
    assert long["std"]["f_nat_hz"] == pytest.approx(1.7e-5, rel=0.1)


def test_a_further_term_has_its_column_and_a_held_parameter_none_of_its_errors(tmp_path):
    done = here(*TERM, "--fix", "lambda_per_s", "--json", tmp_path / "p.json")
    assert done.returncode == 0, done.stderr
    assert "b / rad⁻¹" in done.stdout
    free = here(*TERM, "--json", tmp_path / "free.json")
    assert free.returncode == 0, free.stderr
    held, all_free = (json.loads((tmp_path / f"{n}.json").read_text())["windows"][0]["std"] for n in ("p", "free"))
    assert set(all_free) - set(held) == {"lambda_per_s"}
    assert held["quadratic_drag_per_rad"] < 0.5 * all_free["quadratic_drag_per_rad"]


def test_the_value_of_a_held_parameter_can_be_given_with_it(tmp_path):
    done = here(*TERM[:-2], "--fix", "quadratic_drag_per_rad=2e-4", "--json", tmp_path / "p.json")
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "p.json").read_text())
    assert found["expected"]["quadratic_drag_per_rad"] == 2e-4
    assert "quadratic_drag_per_rad" not in found["windows"][0]["std"]
    assert_one_line_error(here(*TERM, "--fix", "lamda_per_s"), 2, "--fix", "lamda_per_s", "lambda_per_s")
