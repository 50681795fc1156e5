"""Data compressed in a way that this HDF5 library cannot undo: the file is whole, and that is said."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from drivers.errors import RecordingError
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.state.errors import MissingFilter
from tests.kit.recording_files import MINIMAL, NO_FILTER, packed_by, write_minimal


def test_a_filter_that_is_missing_is_no_damage(tmp_path: Path) -> None:
    path = write_minimal(tmp_path / "a.h5", {"/data": packed_by(NO_FILTER, MINIMAL["/data"])})
    recording = open_recording(path)
    with pytest.raises(MissingFilter, match=r"/data: is compressed by the filter of the number 64999") as found:
        recording.frame_volts(0)
    assert "HDF5_PLUGIN_PATH" in found.value.remedy
    assert "record again" not in str(found.value)


def test_so_is_one_of_a_table(tmp_path: Path) -> None:
    path = write_minimal(
        tmp_path / "a.h5", {"/calibration/sensitivity": packed_by(NO_FILTER, MINIMAL["/calibration/sensitivity"])}
    )
    with pytest.raises(MissingFilter, match="/calibration/sensitivity"):
        open_recording(path)


@pytest.mark.parametrize(
    ("begin", "says"),
    [
        (b"\x1f\x8b\x08", "packed by gzip.*gunzip"),
        (b"MATLAB 5.0 MAT-file", "let its name end in .mat"),
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


def test_a_filter_of_hdf5plugin_is_used_where_that_is_installed(tmp_path: Path) -> None:
    """In a process of its own, which has not imported it; netCDF4 has told it of no other filters."""
    pytest.importorskip("hdf5plugin")
    environment = {name: value for name, value in os.environ.items() if name != "HDF5_PLUGIN_PATH"}
    path = write_minimal(tmp_path / "a.h5", {"/data": None})
    write = "import sys, h5py, hdf5plugin, numpy; f = h5py.File(sys.argv[1], 'a')\n"
    write += "f.create_dataset('data', data=numpy.ones((2, 3, 124)), **hdf5plugin.Blosc())"
    read = "import sys; from platform_daemon.core.recordings.reader import open_recording\n"
    read += "assert 'hdf5plugin' not in sys.modules; print(open_recording(sys.argv[1]).frame_volts(1).sum())"
    for program, said in ((write, ""), (read, "372.0")):
        words = [sys.executable, "-c", program, path]
        done = subprocess.run(words, capture_output=True, text=True, env=environment, check=False)
        assert (done.returncode, done.stdout.strip()) == (0, said), done.stderr
