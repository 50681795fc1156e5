"""`platform-daemon tune`: what it finds is used by `measure`, and what never rings ends with 3."""

import pytest

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.features.procedures import command
from platform_daemon.features.procedures.schema import ProcedureLog
from tests.kit.command_line import here


@pytest.fixture(autouse=True)
def kernels_are_there(monkeypatch):
    """Other tests of this process may have compiled them; the first fit does so otherwise."""
    monkeypatch.setattr(command, "prepare_fit", lambda: None)


def test_the_sequence_found_is_told_kept_and_used_by_measure(tmp_path):
    files = ("--output", tmp_path / "t.h5", "--json", tmp_path / "t.json", "--presets", tmp_path / "presets")
    done = here("tune", "--resonator", "jewel", *files)
    assert done.returncode == 0, done.stderr
    assert "f_nat 213." in done.stdout
    assert "kept as preset jewel@1" in done.stdout
    found = ProcedureLog.model_validate_json((tmp_path / "t.json").read_text()).result.outcome
    options = ("--presets", tmp_path / "presets", "--window", "n50", "--out", tmp_path / "m.h5")
    assert here("measure", "--resonator", "jewel", *options).returncode == 0
    recording = open_recording(tmp_path / "m.h5")
    assert recording.rx_volts(0).shape[1] == pytest.approx(found.sequence.rx_s * recording.sequence.rate_hz, abs=1)


def test_what_never_rings_ends_with_3_and_a_remedy(tmp_path):
    options = ("--axis", "0,1,0", "--output", tmp_path / "t.h5", "--presets", tmp_path / "presets")
    done = here("tune", "--resonator", "thread", *options)
    assert done.returncode == 3
    assert "nothing rings" in done.stderr.splitlines()[-1]
    assert "Remedy" in done.stderr
    assert open_recording(tmp_path / "t.h5").frames == 3
