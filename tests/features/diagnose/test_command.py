"""`platform-daemon diagnose`, as a user meets it."""

import json
import signal
import subprocess

import numpy as np
import pytest

from tests.kit.command_line import COMMAND, assert_one_line_error, here, run
from tests.kit.specimen_files import JEWEL, RUNS, THREAD, copied, first_frames, pendulum, swing

KEYS = {
    "verdict", "effects", "held_out", "parameters_before", "parameters_after", "n50_d30", "integrity",
    "missing_torque", "next_measurements", "seconds",
}  # fmt: skip


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clean")
    done = run("diagnose", THREAD, "--json", folder / "d.json", "--html", folder / "d.html", timeout=300)
    assert done.returncode == 0, done.stderr
    assert (folder / "d.html").read_text().startswith("<!doctype html>")
    return done.stdout, json.loads((folder / "d.json").read_text())


@pytest.mark.long
def test_a_clean_recording_lacks_nothing(clean):
    text, report = clean
    assert set(report) >= KEYS
    assert report["verdict"] == "nothing_missing"
    assert report["effects"] == []
    assert report["held_out"]["n_shots"] == 2
    assert report["held_out"]["chi2_per_dof_after"] == pytest.approx(1.0, abs=0.03)
    assert report["files"] == [str(THREAD)]
    assert "Nothing is missing" in text
    assert "f_nat / Hz" in text


def test_one_shot_is_split_in_time_and_says_so(tmp_path):
    done = here("diagnose", first_frames(tmp_path, 1), "--json", tmp_path / "d.json")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "d.json").read_text())
    assert report["held_out"]["n_shots"] == 1
    assert any("one shot only" in note for note in report["notes"])
    assert "predicted from its beginning" in done.stdout


def test_angles_run_through_the_same_code(tmp_path):
    paths = [pendulum(tmp_path, *swing(seed=k), name=f"swing{k}.h5") for k in (1, 2)]
    options = ("--observable", "angle", "--variant", "thread_small_angle", "--json", tmp_path / "d.json")
    done = here("diagnose", *paths, *options)
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "d.json").read_text())
    assert report["verdict"] == "nothing_missing"
    assert report["held_out"]["n_shots"] == 2
    assert report["n50_d30"] == {}
    assert report["parameters_after"]["f_nat_hz"]["value"] == pytest.approx(2.0, rel=1e-3)


@pytest.mark.campaign
def test_measured_pendulums_get_a_verdict_and_a_page(tmp_path):
    options = ("--observable", "angle", "--json", tmp_path / "d.json", "--html", tmp_path / "d.html")
    done = here("diagnose", *RUNS, *options)
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "d.json").read_text())
    held_out = report["held_out"]
    assert held_out["n_shots"] == 3
    assert held_out["nrmse_after"] <= held_out["nrmse_before"]
    assert {e["strength"]["unit"] for e in report["effects"]} & {"A m^2/s"} == set()
    assert "rotary_pendulum_run3" in (tmp_path / "d.html").read_text()


def test_bad_input_is_one_line_and_no_ranking(tmp_path):
    assert_one_line_error(here("diagnose", tmp_path / "none.h5"), 2, "no such file")
    assert_one_line_error(here("diagnose", THREAD, JEWEL), 2, "different resonators")
    assert_one_line_error(here("diagnose", THREAD, "--observable", "colour"), 2, "--observable")
    assert_one_line_error(here("diagnose", THREAD, "--base", "nonsense"), 2, "nonsense")


def test_shots_that_cannot_be_fitted_end_with_3(tmp_path):
    t, _ = swing()
    noise = pendulum(tmp_path, t, np.random.default_rng(2).normal(0.0, 0.01, t.size))
    assert_one_line_error(here("diagnose", noise), 3, "no shot can be used", "no_signal")


def test_files_that_exist_are_kept_unless_forced(tmp_path):
    (tmp_path / "d.json").write_text("mine")
    assert_one_line_error(here("diagnose", THREAD, "--json", tmp_path / "d.json"), 2, "--force")
    assert (tmp_path / "d.json").read_text() == "mine"


def test_an_interrupt_ends_it_without_a_trace(tmp_path):
    one = copied(tmp_path)
    many = [tmp_path / f"{k}.h5" for k in range(150)]  # more than are diagnosed before the signal
    for each in many:
        each.hardlink_to(one)
    command = [COMMAND, "diagnose", *many, "--json", tmp_path / "d.json"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(timeout=2.5)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    # A shell shows 130 for both: Python ends by the signal itself where that struck in code made from a string.
    assert process.returncode in (130, -signal.SIGINT)
    assert "Traceback" not in errors
    written = tmp_path / "d.json"  # there only if the signal came in the last moment, and then whole
    assert not written.exists() or json.loads(written.read_text())
