"""What is in a folder, and nothing outside it."""

from __future__ import annotations

from pathlib import Path

import pytest

from platform_daemon.store.errors import UnknownRecording
from platform_daemon.store.index import list_recordings, resolve
from platform_daemon.store.reader import open_recording
from platform_daemon.store.series_writer import SeriesWriter
from tests.kit.recording_files import START, header, shot, write_minimal, write_series


def test_recordings_are_listed_and_broken_files_reported(tmp_path: Path) -> None:
    write_series(tmp_path / "b.h5", 2)
    write_minimal(tmp_path / "a.mmr.h5")
    (tmp_path / "broken.h5").write_text("no")
    (tmp_path / "notes.txt").write_text("no")
    (tmp_path / "folder.h5").mkdir()
    with SeriesWriter.create(tmp_path / "running.h5", header()) as writer:
        writer.add_shot(shot(1))
        listing = list_recordings(tmp_path)
    foreign, own = listing.recordings
    assert (foreign.identifier, foreign.frames, foreign.incomplete) == ("a.mmr", 2, None)
    assert foreign.date.endswith("+00:00")
    assert (own.identifier, own.frames, own.variant, own.date) == ("b", 2, "thread", START)
    assert own.incomplete == "stopped after 2 of 3 shots"
    assert own.size_bytes == (tmp_path / "b.h5").stat().st_size
    assert [(b.identifier, b.error.what) for b in listing.broken] == [("broken", "not an HDF5 file")]


def test_two_files_with_one_id_are_reported(tmp_path: Path) -> None:
    write_minimal(tmp_path / "a.h5")
    write_minimal(tmp_path / "a.mmr")
    listing = list_recordings(tmp_path)
    assert [e.path.name for e in listing.recordings] == ["a.h5"]
    assert "same id" in str(listing.broken[0].error)
    assert resolve(tmp_path, "a").name == "a.h5"


def test_a_file_that_vanishes_while_listing_is_no_error(tmp_path: Path, monkeypatch) -> None:
    path = write_minimal(tmp_path / "a.h5")
    opened = open_recording(path)
    monkeypatch.setattr("platform_daemon.store.index.open_recording", lambda p: (path.unlink(), opened)[1])
    listing = list_recordings(tmp_path)
    assert (listing.recordings, listing.broken) == ((), ())


def test_a_folder_that_does_not_exist_is_empty(tmp_path: Path) -> None:
    assert list_recordings(tmp_path / "none").recordings == ()


@pytest.mark.parametrize(
    "identifier",
    ["..", ".", "", "/etc/passwd", "../outside", "folder/../a", "a.h5", ".hidden", "a\0", "*", "%2e%2e/outside"],
)
def test_ids_lead_nowhere_but_to_recordings_of_the_folder(tmp_path: Path, identifier: str) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    write_minimal(tmp_path / "outside.h5")
    write_minimal(inside / "a.h5")
    write_minimal(inside / ".hidden.h5")
    assert resolve(inside, "a") == inside / "a.h5"
    with pytest.raises(UnknownRecording):
        resolve(inside, identifier)


def test_a_series_that_runs_is_no_recording_yet_and_that_is_said(tmp_path: Path) -> None:
    with SeriesWriter.create(tmp_path / "running.h5", header()) as writer:
        writer.add_shot(shot(1))
        with pytest.raises(UnknownRecording, match="put together when the series has ended"):
            resolve(tmp_path, "running")
