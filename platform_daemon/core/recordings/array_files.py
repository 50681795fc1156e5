"""Files of arrays by name: npz, and MATLAB's (version 4 to 7.3); archives that hold one table, as phyphox makes."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError

from .text_table import OCTAVE, Table, only_arrays, text_table, vector_or_matrix

_HDF5 = b"\x89HDF\r\n\x1a\n"
_HDF5_AT = 512  # MATLAB's own header stands before
_TABLES = (".csv", ".tsv", ".txt", ".dat")


def npz_table(path: Path) -> Table:
    """Raises RecordingError."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return {name: np.asarray(arrays[name], dtype=np.float64) for name in arrays.files}
    except (OSError, ValueError, TypeError, zipfile.BadZipFile) as error:
        remedy = "write it by numpy.savez(path, time_s=..., dmdt_am2_per_s=...)"
        raise RecordingError("cannot be read as npz", where=str(path), why=str(error), remedy=remedy) from None


def matlab_table(path: Path) -> Table:
    """The arrays of real numbers in a file that MATLAB or Octave wrote, those in structures as `s.t`.

    Raises RecordingError.
    """
    content = path.read_bytes()
    if content.startswith(OCTAVE.encode()):
        return text_table(content, str(path))
    try:
        found = list(_hdf5_arrays(path) if content[_HDF5_AT:].startswith(_HDF5) else _arrays(_loaded(path)))
    except Exception as error:  # a damaged file: scipy raises whatever its parser meets
        remedy = "save it again, as save('own.mat', 'time_s', 'phi_rad')"
        raise RecordingError(
            "cannot be read as a MATLAB file", where=str(path), why=str(error), remedy=remedy
        ) from None
    return only_arrays(found, str(path))


def zipped_table(path: Path) -> Table:
    """The one table of an archive; files about the device (`meta/`) are none.  Raises RecordingError."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = [PurePosixPath(name) for name in archive.namelist()]
            tables = [str(n) for n in names if n.suffix.lower() in _TABLES and not {"meta", "__MACOSX"} & {*n.parts}]
            if len(tables) != 1:
                why = f"it holds {', '.join(tables[:10]) or 'no table'}"
                remedy = "unpack it, and open one table"
                raise RecordingError("is no archive of one table", where=str(path), why=why, remedy=remedy)
            return text_table(archive.read(tables[0]), f"{path}: {tables[0]}")
    except (OSError, zipfile.BadZipFile, RuntimeError) as error:  # RuntimeError: it needs a password
        remedy = "export it again"
        raise RecordingError("cannot be read as zip", where=str(path), why=str(error), remedy=remedy) from None


def _loaded(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    return dict(loadmat(str(path), appendmat=False))


def _arrays(variables: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, NDArray[np.float64]]]:
    for name, value in variables.items():
        if name.startswith("__") or not isinstance(value, np.ndarray):
            continue
        if value.dtype.names and value.size == 1:
            inner = value.reshape(-1)[0]
            yield from _arrays({field: inner[field] for field in value.dtype.names}, f"{prefix}{name}.")
        elif value.dtype.kind in "fiu" and value.ndim == 2:
            yield f"{prefix}{name}", vector_or_matrix(value.astype(np.float64))


def _hdf5_arrays(path: Path) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Of version 7.3; dimensions come reversed.  A missing array is stored as its shape, and marked."""
    import h5py

    found: list[tuple[str, NDArray[np.float64]]] = []

    def take(name: str, each: Any) -> None:
        if not isinstance(each, h5py.Dataset) or name.startswith("#") or "MATLAB_empty" in each.attrs:
            return
        if each.dtype.kind in "fiu" and each.ndim == 2 and each.attrs.get("MATLAB_class") not in (b"char", b"logical"):
            found.append((name.replace("/", "."), vector_or_matrix(each[()].T.astype(np.float64))))

    with h5py.File(path, "r") as file:
        file.visititems(take)
    yield from found
