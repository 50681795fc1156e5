"""What `info` prints: tables no wider than the terminal, and only what the file says."""

import h5py
import pytest

from drivers.errors import RecordingError
from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.features.recordings.report import print_recording
from tests.kit.data import DATA
from tests.kit.recording_files import header, shot


def printed(path, capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    print_recording(describe(open_recording(path)))
    return capsys.readouterr().out


@pytest.mark.parametrize("columns", [80, 120])
@pytest.mark.parametrize("name", ["example_jewel.mmr.h5", "example_thread.mmr.h5"])
def test_no_line_is_wider_than_the_terminal_and_nothing_unsaid_is_printed(name, columns, capsys, monkeypatch):
    text = printed(DATA / name, capsys, monkeypatch, columns)
    assert max(map(len, text.splitlines())) <= columns
    assert "None" not in text
    assert "operator" not in text


@pytest.mark.parametrize(("clock", "shown"), [("simulated", True), ("real", False), (None, False)])
def test_simulated_time_is_marked(clock, shown, tmp_path, capsys, monkeypatch):
    with SeriesWriter.create(tmp_path / "a.h5", header(clock=clock)) as writer:
        writer.add_shot(shot(1))
        path = writer.finish()
    assert describe(open_recording(path)).clock == clock
    assert ("(simulated time)" in printed(path, capsys, monkeypatch, 120)) is shown


def test_a_clock_that_is_neither_is_a_defect_of_the_file(tmp_path):
    with SeriesWriter.create(tmp_path / "a.h5", header(clock="real")) as writer:
        writer.add_shot(shot(1))
        path = writer.finish()
    with h5py.File(path, "r+") as file:
        del file["entry/clock"]
        file["entry/clock"] = "sundial"
    with pytest.raises(RecordingError, match=r"entry/clock.*real or simulated"):
        open_recording(path)
