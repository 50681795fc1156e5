"""What is in a folder, and nothing outside it."""

from __future__ import annotations

from pathlib import Path

import pytest

from platform_daemon.core.recordings.index import list_recordings, resolve
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.state.errors import UnknownRecording
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
    assert (foreign.id, foreign.frames, foreign.incomplete) == ("a.mmr", 2, None)
    assert foreign.date.endswith("+00:00")
    assert (own.id, own.frames, own.variant, own.date) == ("b", 2, "thread", START)
    assert own.incomplete == "stopped after 2 of 3 shots"
    assert own.size_bytes == (tmp_path / "b.h5").stat().st_size
    assert [(b.id, b.error.what) for b in listing.broken] == [("broken", "not an HDF5 file")]


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
    monkeypatch.setattr("platform_daemon.core.recordings.index.open_recording", lambda p: (path.unlink(), opened)[1])
    listing = list_recordings(tmp_path)
    assert (listing.recordings, listing.broken) == ((), ())


def test_newest_first_by_the_time_in_the_name_page_by_page(tmp_path: Path) -> None:
    names = ("acquisition-20260103T000000-b", "own", "procedure-20260102T000000-a", "acquisition-20260101T000000-c")
    for name in sorted(names):
        write_minimal(tmp_path / f"{name}.h5")
    expected = [names[0], names[2], names[3], names[1]]
    assert [each.id for each in list_recordings(tmp_path, newest=True).recordings] == expected
    first = list_recordings(tmp_path, newest=True, limit=2)
    assert [each.id for each in first.recordings] == expected[:2]
    rest = list_recordings(tmp_path, newest=True, limit=2, after=first.last or "")
    assert ([each.id for each in rest.recordings], rest.last) == (expected[2:], None)


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
