"""Data compressed in a way that this HDF5 library cannot undo: the file is whole, and that is said."""

from __future__ import annotations

from pathlib import Path

import pytest

from drivers.errors import RecordingError
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.state.errors import MissingFilter
from tests.kit.recording_files import BLOSC, MINIMAL, packed_by, write_minimal


@pytest.mark.parametrize(("number", "called"), [(BLOSC, "Blosc 32001"), (64999, "of the number 64999")])
def test_a_filter_that_is_missing_is_no_damage(tmp_path: Path, number: int, called: str) -> None:
    path = write_minimal(tmp_path / "a.h5", {"/data": packed_by(number, MINIMAL["/data"])})
    recording = open_recording(path)
    with pytest.raises(MissingFilter, match=rf"/data: is compressed by the filter {called}.*HDF5_PLUGIN_PATH") as found:
        recording.frame_volts(0)
    assert "record again" not in str(found.value)


def test_so_is_one_of_a_table(tmp_path: Path) -> None:
    path = write_minimal(
        tmp_path / "a.h5", {"/calibration/sensitivity": packed_by(BLOSC, MINIMAL["/calibration/sensitivity"])}
    )
    with pytest.raises(MissingFilter, match="/calibration/sensitivity"):
        open_recording(path)


@pytest.mark.parametrize(
    ("begin", "says"),
    [
        (b"\x1f\x8b\x08", "packed by gzip.*gunzip"),
        (b"MATLAB 5.0 MAT-file", "save it with -v7.3"),
        (b"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"),
        (b"CDF\x01", "nccopy"),
        (b"<html>", "signature is missing"),
    ],
)
def test_what_another_program_has_to_undo_is_named(tmp_path: Path, begin: bytes, says: str) -> None:
    path = tmp_path / "a.h5"
    path.write_bytes(begin + bytes(100))
    with pytest.raises(RecordingError, match=rf"not an HDF5 file.*{says}"):
        open_recording(path)
