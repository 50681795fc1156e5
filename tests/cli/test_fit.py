"""`platform-daemon fit` of many files, as a user meets it."""

import json
import signal
import subprocess

import h5py
import numpy as np
import pytest

from platform_daemon.analysis.fit import fit_frame
from platform_daemon.analysis.fit_request import FitRequest
from platform_daemon.estimation.refusal import Refusal
from platform_daemon.store.reader import open_recording
from tests.cli.test_main import COMMAND, assert_one_line_error, here, run, wait_for
from tests.kit.example_copies import copies, links, same
from tests.kit.specimen_files import pendulum, swing

SHORT = ("--window", "0.1")


def lines(path):
    return path.read_text().splitlines() if path.exists() else []


def test_a_bad_file_among_others_costs_the_exit_code_only(tmp_path):
    paths = copies(tmp_path, 2)
    bad = tmp_path / "bad.h5"
    bad.write_bytes(b"no hdf5")
    done = run("fit", bad, *paths, *SHORT, "--json", tmp_path / "all.json")
    assert done.returncode == 2
    assert "bad.h5" in done.stderr
    assert "2 of 2 frames good" in done.stdout
    entries = json.loads((tmp_path / "all.json").read_text())["files"]
    assert [("error" in e, e["file"]) for e in entries] == [(True, str(bad)), *((False, str(p)) for p in paths)]
    assert "HDF5" in entries[0]["error"]["detail"]


MANY = 24  # files: more than are fitted before a signal arrives


def test_a_batch_interrupted_goes_on_where_it_was(tmp_path):
    paths = links(tmp_path, MANY)
    kept, whole = tmp_path / "r.jsonl", tmp_path / "all.json"
    command = [COMMAND, "fit", *paths, *SHORT, "--jsonl", kept, "--processes", "2"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wait_for(lambda: len(lines(kept)) >= 2)
    process.send_signal(signal.SIGINT)
    errors = process.communicate(timeout=30)[1]
    assert process.returncode == 130
    assert "Traceback" not in errors
    before = lines(kept)
    assert f"{len(before)} of {MANY} files are finished" in errors
    done = run("fit", *paths, *SHORT, "--jsonl", kept, "--resume", "--json", whole)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("finished before") == len(before) < MANY
    assert lines(kept)[: len(before)] == before
    assert len(lines(kept)) == MANY
    reports = json.loads(whole.read_text())["files"]
    assert [r["file"] for r in reports] == [str(p) for p in paths]
    assert all(same(r["frames"], reports[k % 2]["frames"]) for k, r in enumerate(reports))


def test_a_killed_batch_leaves_no_process_and_only_its_last_line_can_be_cut(tmp_path):
    paths = links(tmp_path, 16)
    kept = tmp_path / "r.jsonl"
    command = [COMMAND, "fit", *paths, *SHORT, "--jsonl", kept, "--processes", "2"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    wait_for(lambda: len(lines(kept)) >= 2)
    process.kill()
    # Standard output is at its end only when all processes that inherited it have ended.
    process.communicate(timeout=30)
    assert all(json.loads(line)["report"]["frames"] for line in lines(kept)[:-1])


def test_results_kept_before_are_not_overwritten_unasked(tmp_path):
    (path,) = copies(tmp_path, 1)
    (tmp_path / "r.jsonl").write_text("something\n")
    assert_one_line_error(here("fit", path, "--jsonl", tmp_path / "r.jsonl"), 2, "r.jsonl", "--force")
    assert_one_line_error(here("fit", path, "--jsonl", tmp_path / "r.jsonl", "--resume"), 2, "line 1")
    assert_one_line_error(here("fit", path, "--resume"), 2, "--jsonl")
    assert (tmp_path / "r.jsonl").read_text() == "something\n"


def test_derived_quantities_are_added_to_the_fixed_form(tmp_path):
    (path,) = copies(tmp_path, 1)
    done = here("fit", path, *SHORT, "--derived", "--json", tmp_path / "d.json")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "d.json").read_text())
    derived = report["frames"][0]["derived"]
    assert derived["equivalent_quality_factor"] < derived["quality_factor"]
    assert derived["equivalent_quality_factor_to_infinity"] == pytest.approx(458, rel=0.2)
    assert len(report["derived"]["orientation_error"]["against_best"]["angle_rad"]) == 2
    assert any("allan" in note for note in report["derived"]["notes"])


def test_slide_draws_flat_lines_and_says_how_flat(tmp_path):
    (path,) = copies(tmp_path, 1)
    done = here("slide", path, "--window", "0.12", "--out", tmp_path / "s.png", "--json", tmp_path / "s.json")
    assert done.returncode == 0, done.stderr
    assert "f_nat_hz" in done.stdout
    assert (tmp_path / "s.png").read_bytes().startswith(b"\x89PNG")
    report = json.loads((tmp_path / "s.json").read_text())
    assert [w["verdict"] for w in report["windows"]] == ["good"] * 8
    assert report["flatness"]["m_r_am2"]["probability"] > 1e-4
    assert_one_line_error(here("slide", path, "--window", "5"), 2, "--window")
    assert_one_line_error(here("slide", path, "--lambda", "loose"), 2, "--lambda")
    assert_one_line_error(here("slide", path, "--frame", "9"), 2, "frame 9")


def with_a_bad_sample(folder):
    """Both example files, the second frame of each with a NaN."""
    paths = copies(folder, 2)
    for path in paths:
        with h5py.File(path, "r+") as file:
            file["data"][1, 2, -100] = np.nan
    return paths


def test_a_sample_that_is_no_number_is_named_with_its_place_and_its_frame_can_be_left_out(tmp_path):
    path, _ = with_a_bad_sample(tmp_path)
    done = here("fit", path, *SHORT)
    assert done.returncode == 0
    said = " ".join(done.stdout.split())
    assert "frame 1: refused: not_finite: value is nan at " in said
    assert "/data[frame 1, channel 2, sample " in said
    assert "not_finite" not in here("fit", path, *SHORT, "--frames", "0").stdout
    assert_one_line_error(here("fit", path, *SHORT, "--frames", "1"), 2, "not_finite", "--frames", "`frames`")
    assert_one_line_error(here("fit", path, *SHORT, "--frames", "2"), 2, "frame 2 does not exist", "0 to 1")


@pytest.mark.parametrize("processes", ["1", "2"])
def test_only_the_frames_asked_for_are_fitted_however_the_work_is_split(tmp_path, processes):
    paths = copies(tmp_path, 2)
    for path in paths:
        with h5py.File(path, "r+") as file:
            volts = np.repeat(file["data"][:], 3, axis=0)
            del file["data"]
            file["data"] = volts
    asked = (*SHORT, "--frames", "1,3-5", "--processes", processes, "--json", tmp_path / "r.json")
    done = here("fit", *paths, *asked)
    assert done.returncode == 0, done.stderr
    for report in json.loads((tmp_path / "r.json").read_text())["files"]:
        assert [f["frame"] for f in report["frames"]] == [1, 3, 4, 5]
        assert all(f["verdict"] == "good" for f in report["frames"])


def test_a_clipped_frame_is_refused_with_what_to_do(tmp_path):
    (path,) = copies(tmp_path, 1)
    recording = open_recording(path)
    volts = recording.rx_volts(0)
    volts[0] = np.clip(volts[0], -0.7 * volts[0].max(), 0.7 * volts[0].max())
    fit = fit_frame(volts, recording.sequence.rate_hz, recording.calibration, FitRequest("jewel", 0.1))
    assert fit.code is Refusal.SATURATED
    assert fit.reason.startswith("saturated: ")
    assert fit.reason.endswith(Refusal.SATURATED.value)


def test_an_angle_is_fitted_among_recordings(tmp_path):
    (path,), angle = copies(tmp_path, 1), pendulum(tmp_path, *swing())
    done = run("fit", path, angle, "--window", "10", "--derived", "--json", tmp_path / "all.json")
    assert done.returncode == 0, done.stderr
    recording, report = json.loads((tmp_path / "all.json").read_text())["files"]
    (frame,) = report["frames"]
    assert (report["variant"], report["notes"], set(report)) == ("thread", [], set(recording))
    assert set(frame["parameters"]) == {"f_nat_hz", "lambda_per_s", "phi_max_rad", "psi_start_rad"}
    assert frame["parameters"]["lambda_per_s"]["value"] == pytest.approx(0.15, rel=0.05)
    assert frame["derived"]["quality_factor"] == pytest.approx(2 * 3.1416 / 0.15, rel=0.05)


def test_the_table_shows_what_was_fitted_and_nothing_else(tmp_path):
    shown = here("fit", pendulum(tmp_path, *swing()), "--variant", "jewel_constant_friction", "--window", "10").stdout
    assert "coulomb_rad_per_s2" in shown
    assert "m_r" not in shown


def test_what_an_angle_has_not_is_an_error_that_says_so(tmp_path):
    angle = pendulum(tmp_path, *swing())
    assert_one_line_error(here("fit", angle, "--fix", "m_r_am2=0.01"), 2, "without calibration")
    (path,) = copies(tmp_path, 1)
    assert_one_line_error(here("fit", angle, "--calibration", path), 2, "no calibration applies")
    assert_one_line_error(here("fit", angle, "--variant", "rubber"), 2, "rubber")
    assert_one_line_error(here("slide", angle, "--frame", "1"), 2, "frame 1")
    assert_one_line_error(here("info", angle), 2, "fit, slide and diagnose take an angle")


def test_slide_goes_along_an_angle(tmp_path):
    angle = pendulum(tmp_path, *swing(seconds=40.0, decay_per_s=0.02))
    done = here("slide", angle, "--variant", "thread_small_angle", "--window", "8", "--json", tmp_path / "s.json")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "s.json").read_text())
    assert [w["verdict"] for w in report["windows"]] == ["good"] * 5
    assert report["flatness"]["f_nat_hz"]["mean"] == pytest.approx(2.0, abs=1e-3)
