"""Data compressed in a way that this HDF5 library cannot undo: the file is whole, and that is said."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.state.errors import MissingFilter
from tests.kit.recording_files import MINIMAL, write_minimal

BLOSC = 32001


def packed_by(number: int, values: np.ndarray):
    """Writes a dataset whose one chunk claims to be packed by a filter of that number."""

    def write(h5: h5py.File, name: str) -> None:
        plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        plan.set_chunk(values.shape)
        plan.set_filter(number, h5py.h5z.FLAG_OPTIONAL, ())  # optional, so that HDF5 makes it without the filter
        kind, space = h5py.h5t.py_create(values.dtype), h5py.h5s.create_simple(values.shape)
        group, _, last = name.rpartition("/")
        made = h5py.h5d.create(h5.require_group(group or "/").id, last.encode(), kind, space, plan)
        made.write_direct_chunk((0,) * values.ndim, values.tobytes(), filter_mask=0)

    return write


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
