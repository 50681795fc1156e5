"""`platform-daemon characterise` of a recording."""

import json

import pytest

from platform_daemon.features.characterise.schema import CharacterisationReport
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.data import DATA
from tests.kit.ring_down_series import jewels, write_ring_downs


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return write_ring_downs(tmp_path_factory.mktemp("cli") / "jewels.h5", jewels(3))


def test_a_recording_becomes_tables_json_and_a_page(path, tmp_path):
    done = here("characterise", "--from", path, "--json", tmp_path / "c.json", "--html", tmp_path / "c.html")
    assert done.returncode == 0, done.stderr
    for title in ("How well the model fits", "Fitted parameters", "N50 against D30", "Quality factors"):
        assert title in done.stdout
    assert str(tmp_path / "c.html") in done.stdout
    report = CharacterisationReport.model_validate_json((tmp_path / "c.json").read_text())
    assert (report.n50.good, report.d30.good, report.file) == (3, 3, str(path))
    assert (tmp_path / "c.html").read_text().startswith("<!doctype html>")
    again = here("characterise", "--from", path, "--json", tmp_path / "c.json")
    assert_one_line_error(again, 2, "--force")


def test_frames_variant_level_and_held_losses_can_be_chosen(path, tmp_path):
    held = ("--hold", "lambda_per_s=0.3", "--alpha", "0.01", "--frames", "0-1", "--variant", "jewel")
    done = here("characterise", "--from", path, *held, "--json", tmp_path / "c.json")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "c.json").read_text())
    assert (report["alpha"], report["n50"]["held"], report["d30"]["shots"]) == (0.01, {"lambda_per_s": 0.3}, 2)
    assert "0.3 held" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--hold", "m_r_am2=1"), ("m_r_am2", "lambda_per_s")),
        (("--hold", "lambda_per_s"), ("--hold",)),
        (("--frames", "9"), ("frame 9",)),
        (("--alpha", "2"), ("--alpha",)),
        (("--variant", "rope"), ("rope",)),
    ],
)
def test_what_makes_no_sense_is_said_before_anything_is_fitted(path, arguments, words):
    assert_one_line_error(here("characterise", "--from", path, *arguments), 2, *words)


def test_files_that_hold_no_shots_of_a_resonator(tmp_path):
    assert_one_line_error(here("characterise", "--from", tmp_path / "no.h5"), 2, "no such file")
    assert_one_line_error(here("characterise", "--from", DATA / "measured" / "r5_hung_rod_a.h5"), 2, "time series")
    assert_one_line_error(here("characterise"), 2, "--from", "--resonator")
    assert_one_line_error(here("characterise", "--resonator", "jewel", "--frames", "0"), 2, "--frames")


def test_shots_that_are_all_refused_end_with_3_and_a_report(tmp_path):
    path = write_ring_downs(tmp_path / "none.h5", [None, None])
    done = here("characterise", "--from", path, "--html", tmp_path / "c.html")
    assert done.returncode == 3
    assert "every shot was refused" in done.stderr
    assert (tmp_path / "c.html").exists()


@pytest.mark.long
def test_a_resonator_is_measured_and_characterised_at_once(tmp_path):
    short = ("--resonator", "jewel", "--shots", "2", "--blank-shots", "0", "--rx-s", "0.6", "--pause-s", "5")
    short += ("--no-tune", "--no-ramp")
    plan = here("characterise", *short, "--dry-run")
    assert "2 shots" in plan.stdout
    files = ("--out", tmp_path / "c.h5", "--json", tmp_path / "c.json", "--html", tmp_path / "c.html")
    done = here("characterise", *short, *files)
    assert done.returncode == 0, done.stderr
    assert "N50 against D30" in done.stdout
    report = CharacterisationReport.model_validate_json((tmp_path / "c.json").read_text())
    assert (report.d30.good, report.file) == (2, "c.h5")
    assert (tmp_path / "c.html").exists()
    assert (tmp_path / "c.h5.log.json").exists()
    assert_one_line_error(here("characterise", *short, "--out", tmp_path / "c.h5"), 2, "--force")
