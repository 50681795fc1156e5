"""A file that another program has open is not damaged: it is read later, wherever recordings are listed or kept."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import pytest

from drivers.errors import RecordingError
from platform_daemon.core.recordings.index import list_recordings
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording_index import open_index
from platform_daemon.core.recordings.recovery import recover_all
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.state.errors import RecordingInUse, RecordingUnfinished
from platform_daemon.features.trends.look import look_at_recording
from tests.kit.recording_files import header, shot, write_minimal, write_series


@contextmanager
def open_elsewhere(path: Path) -> Iterator[None]:
    """Another process has the file open for writing."""
    code = f"import h5py; f = h5py.File({str(path)!r}, 'r+'); print('open', flush=True); input()"
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"open\n"
        try:
            yield
        finally:
            other.communicate(b"\n")


def test_a_file_that_is_open_for_writing_is_in_use_until_it_is_closed(tmp_path: Path) -> None:
    """Case 06: not now is not never."""
    path = write_minimal(tmp_path / "a.h5")
    with open_elsewhere(path):
        with pytest.raises(RecordingInUse, match=r"another program has the file open.*Remedy: try again") as seen:
            open_recording(path)
        assert seen.value.http_status == 423
        (broken,) = list_recordings(tmp_path).broken
        assert isinstance(broken.error, RecordingInUse)
    open_recording(path)


def test_the_index_does_not_remember_it_as_damaged(tmp_path: Path) -> None:
    write_series(tmp_path / "a.h5")
    with contextlib.closing(open_index(tmp_path)) as index:
        with open_elsewhere(tmp_path / "a.h5"):
            assert index.update(look_at_recording).in_use == 1
            assert "another program" in index.broken()["a"]
        assert index.update(look_at_recording).in_use == 0
        assert (index.broken(), index.files()[0][0]) == ({}, "a.h5")
        os.utime(tmp_path / "a.h5")
        with open_elsewhere(tmp_path / "a.h5"):
            index.update(look_at_recording)
            assert index.files()[0][0] == "a.h5"  # what is known of it stays


def test_a_shot_that_somebody_looks_at_is_not_set_aside(tmp_path: Path) -> None:
    writer = SeriesWriter.create(tmp_path / "a.h5", header())
    writer.add_shot(shot(1))
    writer._staging.release()  # noqa: SLF001  as the end of the process does
    kept = next(tmp_path.glob(".a.h5.shots/shot_*.h5"))
    with open_elsewhere(kept):
        found = recover_all(tmp_path)
        assert (found.made, len(found.failed)) == ((), 1)
    assert recover_all(tmp_path).made == (tmp_path / "a.h5",)
    assert not list(tmp_path.glob("*.unreadable"))


@pytest.mark.parametrize("size", [0, 3000])
def test_a_file_that_ends_too_early_is_damaged_once_it_changes_no_more(tmp_path: Path, size: int) -> None:
    path = write_minimal(tmp_path / "a.h5")
    os.truncate(path, size)
    with pytest.raises(RecordingUnfinished, match=r"still being written.*Remedy: try again"):
        open_recording(path)
    os.utime(path, (time.time() - 3600,) * 2)
    with pytest.raises(RecordingError, match=r"empty|truncated or damaged") as seen:
        open_recording(path)
    assert not isinstance(seen.value, RecordingInUse)


def test_a_file_that_is_marked_as_open_names_the_way_out(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    code = (
        "import h5py, os; f = h5py.File({!r}, 'w', libver='latest'); f['data'] = [1.0]; f.swmr_mode = True; "
        "f.flush(); os._exit(0)"
    )
    subprocess.run([sys.executable, "-c", code.format(str(path))], check=True)
    with pytest.raises(RecordingInUse, match="h5clear"):
        open_recording(path)
    assert h5py.is_hdf5(path)
