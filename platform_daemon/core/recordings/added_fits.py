"""Further fits for a recording that is finished already."""

from __future__ import annotations

import shutil
from pathlib import Path

import h5py

from drivers.errors import InputError
from platform_daemon.core.state.durable import part_of, publish, reserve, storage_error

from .dimensions import add_fit_scales
from .fit_tables import write_fit
from .header import FitTable
from .reader import open_recording
from .validate import check_fit
from .writer import LIBVER

_SPARE_BYTES = 1 << 20
_BYTES_PER_NUMBER = 16  # more than enough: a number has eight


def add_fit(path: Path, table: FitTable) -> None:
    """Store one more table of fits in a recording of ours, which is replaced by one rename: a reader finds the old file
    or the new one, and a crash leaves the old one.

    Raises InputError if the recording has a table of that name or another number of frames; RecordingError;
    StorageError if the disk is full, with the recording untouched.
    """
    recording = open_recording(path)
    if table.name in recording.fits:
        what, remedy = f"there are fits called {table.name!r} already", "give them another name"
        raise InputError(what, where=str(path), remedy=remedy)
    check_fit(table, recording.frames)
    part = part_of(path)
    numbers = table.covariance.size + recording.frames * (2 * len(table.parameters) + 8)
    try:
        # HDF5 on a full disk ends the whole process: see assembly.py.
        reserve(part, b"", recording.size_bytes + _BYTES_PER_NUMBER * numbers + _SPARE_BYTES)
        with path.open("rb") as source, part.open("r+b") as copy:
            shutil.copyfileobj(source, copy, 1 << 20)
        with h5py.File(part, "r+", libver=LIBVER) as h5:
            write_fit(h5, table)
            add_fit_scales(h5, table.name)
        publish(part, path)
    except (OSError, RuntimeError) as error:  # h5py says RuntimeError when a file cannot be closed
        raise storage_error(path, error) from error
    finally:
        part.unlink(missing_ok=True)
