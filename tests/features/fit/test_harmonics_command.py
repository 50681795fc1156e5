"""`platform-daemon harmonics`: the same numbers as over REST, and near those of the fit."""

import json

import h5py
import numpy as np
import pytest

import platform_daemon as pd_
from platform_daemon.core.command_line.parsing import parse_frames
from platform_daemon.core.schemas.base import to_json
from platform_daemon.features.fit.fit import fit_stored_frame
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.harmonics import frame_harmonics
from platform_daemon.features.fit.measurement import open_voltages
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.data import DATA

JEWEL = DATA / "example_jewel.mmr.h5"


def changed(tmp_path, **frames):
    """A copy of the example in which a sample of each of these frames is that value."""
    path = tmp_path / "changed.h5"
    path.write_bytes(JEWEL.read_bytes())
    with h5py.File(path, "r+") as file:
        for name, value in frames.items():
            file["data"][int(name[1:]), 1, -1000] = value
    return path


def test_every_frame_is_told_in_a_line_and_in_json_as_the_function_behind_rest_gives_it(tmp_path):
    done = here("harmonics", JEWEL, "--json", tmp_path / "h.json")
    assert done.returncode == 0, done.stderr
    recording = open_voltages(JEWEL)
    report = json.loads((tmp_path / "h.json").read_text())
    assert report["file"] == str(JEWEL)
    assert report["frames"] == [json.loads(to_json(frame_harmonics(recording, k))) for k in range(recording.frames)]
    lines = done.stdout.splitlines()
    assert [line.split(":")[0] for line in lines] == [f"frame {k}" for k in range(recording.frames)]
    for line, frame in zip(lines, report["frames"], strict=True):
        assert f"f_nat {frame['f_nat_hz']:.4f} Hz" in line
        assert f"m_r {1e3 * frame['m_r_am2']:.4f} mAm²" in line


def test_the_cross_check_agrees_with_the_fit(tmp_path):
    assert here("harmonics", JEWEL, "--json", tmp_path / "h.json").returncode == 0
    for found in json.loads((tmp_path / "h.json").read_text())["frames"]:
        fit = fit_stored_frame(open_voltages(JEWEL), found["frame"], FitRequest("jewel", "d30"))[0].values
        assert found["f_nat_hz"] == pytest.approx(fit["f_nat_hz"], abs=0.02)
        assert found["m_r_am2"] == pytest.approx(fit["m_r_am2"], rel=2e-3)


def test_many_files_are_told_by_name_and_a_bad_frame_stops_nothing(tmp_path):
    bad = changed(tmp_path, f1=np.nan)
    done = here("harmonics", JEWEL, bad, "--json", tmp_path / "h.json")
    assert done.returncode == 0, done.stderr
    first, second = json.loads((tmp_path / "h.json").read_text())["files"]
    assert [f["verdict"] for f in second["frames"]] == ["good", "refused"]
    assert f"{bad}: frame 1: refused: " in done.stdout
    assert f"{JEWEL}: frame 0: f_nat" in done.stdout
    assert first["frames"][0] == second["frames"][0]


def test_clipped_volts_are_refused_and_give_no_numbers(tmp_path):
    path = changed(tmp_path)
    with h5py.File(path, "r+") as file:
        volts = file["data"][0, 0, -61035:]
        file["data"][0, 0, -61035:] = np.clip(volts, -0.7 * volts.max(), 0.7 * volts.max())
    assert here("harmonics", path, "--json", tmp_path / "h.json").returncode == 0
    refused, good = json.loads((tmp_path / "h.json").read_text())["frames"]
    assert set(refused) == {"frame", "verdict", "reason"}
    assert refused["reason"].startswith("saturated: ")
    assert good["verdict"] == "good"


def test_frames_can_be_chosen_and_must_exist(tmp_path):
    done = here("harmonics", JEWEL, "--frames", "1", "--json", tmp_path / "h.json")
    assert [f["frame"] for f in json.loads((tmp_path / "h.json").read_text())["frames"]] == [1]
    assert done.stdout.startswith("frame 1:")
    assert_one_line_error(here("harmonics", JEWEL, "--frames", "0-9"), 2, "does not exist", "0 to 1")
    assert_one_line_error(here("harmonics", JEWEL, "--frames", "one"), 2, "--frames", "0,2,5-9")
    assert_one_line_error(here("harmonics", JEWEL, "--json", tmp_path / "h.json"), 2, "--force")


@pytest.mark.parametrize(("text", "frames"), [("0", (0,)), ("3, 1,1", (1, 3)), ("2,5-7", (2, 5, 6, 7))])
def test_frames_are_written_as_numbers_and_ranges(text, frames):
    assert parse_frames(text) == frames


def test_a_file_with_nothing_to_read_ends_as_a_fit_does(tmp_path):
    bare = changed(tmp_path)
    with h5py.File(bare, "r+") as file:
        del file["calibration"]
    done = here("harmonics", bare)
    assert done.returncode == 3
    assert "calibrated" in done.stdout
    assert "every frame was refused" in done.stderr
    assert_one_line_error(here("harmonics", changed(tmp_path, f0=np.nan, f1=np.inf)), 2, "frame 0", "channel 1")
    assert_one_line_error(here("harmonics", tmp_path / "none.h5"), 2, "none.h5")


def test_a_table_whose_time_is_in_another_unit_is_doubted(tmp_path):
    sim = pd_.simulate("jewel", phi_max_deg=40, seconds=0.4, seed=1, sampling_rate_hz=5000)
    np.savez(tmp_path / "a.npz", time_s=1e3 * sim.time_s(), dmdt_am2_per_s=sim.signal())
    told = here("harmonics", tmp_path / "a.npz").stderr
    assert "implausible: f_nat is 0.213" in told
    assert "unit of the time" in told
    assert "implausible" not in here("harmonics", JEWEL).stderr
