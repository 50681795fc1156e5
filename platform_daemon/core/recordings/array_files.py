"""Files of arrays by name: npz, and MATLAB's (version 4 to 7.3); archives that hold one table, as phyphox makes."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError

from .octave_text import OCTAVE
from .table import Table, vector_or_matrix, without_scalars
from .text_table import text_table

_HDF5 = b"\x89HDF\r\n\x1a\n"
_HDF5_AT = 512  # MATLAB's own header stands before
_ZIP, _NPY = b"PK", b"\x93NUMPY"
_TABLES = (".csv", ".tsv", ".txt", ".dat")
_NO_NUMBERS = (b"char", b"logical")
_WRITE_NPZ = "write it by numpy.savez(path, time_s=..., dmdt_am2_per_s=...)"


def npz_table(path: Path) -> Table:
    """The arrays of real numbers; dates become seconds since the first.  Raises RecordingError."""
    _refuse_other_than_zip(path)
    found = Table()
    try:
        with np.load(path, allow_pickle=False) as arrays:
            for name in arrays.files:
                _take(found, name, arrays, str(path))
    except RecordingError:
        raise
    except Exception as error:  # a damaged file: zipfile, zlib and numpy raise whatever their parsers meet
        raise RecordingError("cannot be read as npz", where=str(path), why=str(error), remedy=_WRITE_NPZ) from None
    return found


def _refuse_other_than_zip(path: Path) -> None:
    """Raises RecordingError: numpy would take it for a pickle."""
    with path.open("rb") as file:
        begin = file.read(len(_NPY))
    if begin.startswith(_ZIP):
        return
    why, remedy = "it is no archive of arrays", _WRITE_NPZ
    if not begin:
        why = "it is empty"
    elif begin == _NPY:
        why = "it is one array, as numpy.save writes it"
    elif begin.isascii() and begin.decode().isprintable():
        why, remedy = "it begins as text", "let the name of a table of text end in .csv"
    raise RecordingError("cannot be read as npz", where=str(path), why=why, remedy=remedy)


def _take(found: Table, name: str, arrays: Any, where: str) -> None:
    """Put one array into the table, or note why it is left out."""
    try:
        values = arrays[name]
    except ValueError as error:
        if "Object arrays" not in str(error):
            raise
        found.left_out[name] = "it holds Python objects"
        return
    kind = values.dtype.kind
    if kind == "c":
        found.leave_out_complex(name)
    elif kind in "fiub":
        found[name] = values.astype(np.float64)
    elif kind in "mM" and values.size:
        if np.isnat(values).any():
            remedy = "leave samples without a time out"
            raise RecordingError(f"the array {name!r} has entries without a date", where=where, remedy=remedy)
        since = values - values.reshape(-1)[0]
        found[name] = since.astype("timedelta64[ns]").astype(np.int64) * 1e-9
        found.units[name] = "s"
    else:
        found.left_out[name] = f"it holds text, {str(values.reshape(-1)[0])[:30]!r}" if values.size else "it is empty"


def matlab_table(path: Path) -> Table:
    """The arrays of real numbers in a file that MATLAB or Octave wrote, those in structures as `s.t`.

    Raises RecordingError.
    """
    content = path.read_bytes()
    if content.startswith(OCTAVE.encode()):
        return text_table(content, str(path))
    found = Table()
    try:
        in_hdf5 = content.startswith(_HDF5) or content[_HDF5_AT:].startswith(_HDF5)
        for name, values in _hdf5_arrays(path) if in_hdf5 else _arrays(_loaded(path)):
            if values is None:
                found.leave_out_complex(name)
            else:
                found[name] = values
    except Exception as error:  # a damaged file: scipy raises whatever its parser meets
        remedy = "save it again, as save('own.mat', 'time_s', 'phi_rad')"
        raise RecordingError(
            "cannot be read as a MATLAB file", where=str(path), why=str(error), remedy=remedy
        ) from None
    return without_scalars(found, str(path))


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
    except RecordingError:
        raise
    except Exception as error:  # damaged, or with a password: zipfile and zlib raise whatever they meet
        remedy = "export it again"
        raise RecordingError("cannot be read as zip", where=str(path), why=str(error), remedy=remedy) from None


def _loaded(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    return dict(loadmat(str(path), appendmat=False))


def _arrays(variables: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, NDArray[np.float64] | None]]:
    """None: it is complex."""
    for name, value in variables.items():
        if name.startswith("__") or not isinstance(value, np.ndarray):
            continue
        if value.dtype.names and value.size == 1:
            inner = value.reshape(-1)[0]
            yield from _arrays({field: inner[field] for field in value.dtype.names}, f"{prefix}{name}.")
        elif value.dtype.kind == "c":
            yield f"{prefix}{name}", None
        elif value.dtype.kind in "fiu" and value.ndim == 2:
            yield f"{prefix}{name}", vector_or_matrix(value.astype(np.float64))


def _hdf5_arrays(path: Path) -> Iterator[tuple[str, NDArray[np.float64] | None]]:
    """Of version 7.3; dimensions come reversed.  A missing array is stored as its shape, and marked.  None: complex."""
    import h5py

    found: list[tuple[str, NDArray[np.float64] | None]] = []

    def take(name: str, each: Any) -> None:
        if not isinstance(each, h5py.Dataset) or name.startswith("#") or "MATLAB_empty" in each.attrs:
            return
        called = name.replace("/", ".")
        if each.dtype.kind == "c" or each.dtype.names == ("real", "imag"):
            found.append((called, None))
        elif each.dtype.kind in "fiu" and each.ndim in (1, 2) and each.attrs.get("MATLAB_class") not in _NO_NUMBERS:
            found.append((called, vector_or_matrix(each[()].T.astype(np.float64))))

    with h5py.File(path, "r") as file:
        file.visititems(take)
    yield from found
