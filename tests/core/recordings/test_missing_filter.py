"""Data compressed in a way that this HDF5 library cannot undo: the file is whole, and that is said."""

from __future__ import annotations

from pathlib import Path

import pytest

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
