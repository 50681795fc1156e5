"""All declared models and torque terms from the command line; exit codes of refused fits."""

import json

import pytest

from tests.kit.command_line import assert_one_line_error, here, run
from tests.kit.example_copies import copies


@pytest.fixture
def path(tmp_path):
    return copies(tmp_path, 1)[0]


def test_a_further_term_is_fitted_and_told_with_its_error(tmp_path, path):
    done = run(
        "fit", path, "--window", "0.4", "--with-term", "quadratic_drag", "--derived", "--json", tmp_path / "f.json"
    )
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "f.json").read_text())
    assert report["variant"].endswith("+quadratic_drag")
    drag = report["frames"][0]["parameters"]["quadratic_drag_per_rad"]
    assert abs(drag["value"]) < 6 * drag["std"]
    assert "quadratic_drag_per_rad" in report["summary"]
    assert report["frames"][0]["derived"]["equivalent_quality_factor"] > 0


def test_a_variant_without_losses_is_refused_by_name_and_ends_with_3(path):
    done = here("fit", path, "--window", "0.4", "--variant", "undamped")
    assert done.returncode == 3
    assert "model_does_not_explain" in done.stdout


@pytest.mark.parametrize("command", [("fit",), ("slide",), ("plot",)])
def test_an_unknown_variant_is_answered_with_the_names_there_are(path, command):
    assert_one_line_error(here(*command, path, "--variant", "spring"), 2, "spring", "jewel_constant_friction")
    assert_one_line_error(here(*command, path, "--with-term", "wind"), 2, "wind", "quadratic_drag")


def test_slide_ends_as_fit_does_where_the_fit_is_refused_and_names_its_own_options(path):
    done = here("slide", path, "--variant", "undamped")
    assert_one_line_error(done, 3, "refused", "--window")
    assert "window_s" not in done.stderr
    assert_one_line_error(here("slide", path, "--window", "5"), 2, "--window", "--step")


def test_slide_shows_the_constants_of_further_terms(path):
    done = here("slide", path, "--window", "0.2", "--with-term", "quadratic_drag")
    assert done.returncode == 0, done.stderr
    assert "quadratic_drag_per_rad" in done.stdout


def test_predict_takes_any_model_whose_values_are_known():
    plan = ("predict", "--resonator", "thread", "--window", "n50", "--with-term", "quadratic_drag")
    assert_one_line_error(here(*plan), 2, "quadratic_drag_per_rad=VALUE")
    done = here(*plan, "--expect", "quadratic_drag_per_rad=0.001")
    assert done.returncode == 0, done.stderr
    assert "thread+quadratic_drag" in done.stdout
