"""`platform-daemon measure`: the recording, its fits, and what is left of a series that did not end by itself."""

import json
import signal
import subprocess

import h5py
import pytest

from tests.kit.command_line import COMMAND, QUICK, assert_one_line_error, here, run, wait_for
from tests.kit.data import CONFIG


def test_measure_writes_a_recording_and_its_fits(measured):
    report = json.loads((measured / "j.json").read_text())
    assert report["shots"] == 2
    assert [f["verdict"] for f in report["fit"]["frames"]] == ["good", "good"]


def test_measure_takes_a_sequence_file(tmp_path):
    preset = (CONFIG / "sequences" / "jewel.toml").read_text()
    (tmp_path / "s.toml").write_text(preset.replace("490e-6", "300e-6").replace("rx_s = 2.0", "rx_s = 0.4"))
    done = run("measure", "--resonator", "jewel", "--sequence", tmp_path / "s.toml", "--out", tmp_path / "a.h5")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["excitation/field"][0] == pytest.approx(300e-6)
        assert file["sequence/numRxSamples"][()] == round(0.4 * 125e6 / 2048)


def test_measure_never_overwrites_without_force(measured):
    before = (measured / "j.h5").read_bytes()
    assert_one_line_error(here("measure", *QUICK, "--out", measured / "j.h5"), 2, "j.h5", "--force")
    assert (measured / "j.h5").read_bytes() == before


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_measure_keeps_its_finished_shots(tmp_path, number):
    command = [COMMAND, "measure", *QUICK, "--shots", "500", "--out", tmp_path / "a.h5"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for(lambda: list(tmp_path.glob(".*/shot_000002.h5")))
    process.send_signal(number)
    said, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "of 500 shots in" in said
    assert "outputs are off" in errors
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["data"].shape[0] >= 2


def test_shots_of_a_killed_measure_are_recovered_by_the_next(tmp_path):
    command = [COMMAND, "measure", *QUICK, "--shots", "500", "--out", tmp_path / "a.h5"]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    wait_for(lambda: list(tmp_path.glob(".*/shot_000002.h5")))
    process.kill()
    process.wait()
    shots = len(list(tmp_path.glob(".*/shot_??????.h5")))
    done = run("measure", *QUICK, "--out", tmp_path / "a.h5", "--force")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "a.recovered.h5") as file:
        assert file["data"].shape[0] == shots
