"""Files that are whole, and cannot be read as they are: of other programs, or compressed in a way that HDF5 lacks."""

from __future__ import annotations

import contextlib
import importlib
from pathlib import Path

import h5py

from drivers.errors import RecordingError
from platform_daemon.core.state.errors import MissingFilter

_FILTERS = {307: "bzip2", 32000: "LZF", 32001: "Blosc", 32004: "LZ4", 32008: "bitshuffle", 32013: "ZFP"}
_FILTERS |= {32015: "Zstandard", 32026: "Blosc2", 4: "SZIP"}
"""Numbers of filters: https://github.com/HDFGroup/hdf5_plugins/blob/master/docs/RegisteredFilterPlugins.md"""
_OTHERS = {
    b"\x1f\x8b": ("packed by gzip", "unpack it first: gunzip"),
    b"PK\x03\x04": ("a zip or npz file", "unpack it, or let the name of an npz file end in .npz"),
    b"MATLAB 5.0": ("a MATLAB file before version 7.3", "let its name end in .mat"),
    b"CDF": ("a netCDF file before version 4", "convert it: nccopy -k nc4"),
    b"version https://git-lfs": ("a pointer of git LFS in place of the file", "get the file itself: git lfs pull"),
}
"""What other files begin with: what they are, and the remedy."""


def refuse_missing_filters(item: h5py.Dataset, where: str) -> None:
    """Raises MissingFilter for a dataset that HDF5 cannot unpack: what HDF5 says of it looks like damage."""
    made = item.id.get_create_plist()
    used = [made.get_filter(k)[0] for k in range(made.get_nfilters())]
    missing = _missing(used)
    if missing:  # a package that is often installed brings most of them, once it has been imported
        with contextlib.suppress(ImportError):
            importlib.import_module("hdf5plugin")
        missing = _missing(used)
    if missing:
        raise MissingFilter(
            f"is compressed by the filter {_FILTERS.get(missing[0], 'of the number')} {missing[0]}",
            where=where,
            why="The HDF5 library of this installation does not have it; the file may be whole",
            remedy="install the Python package hdf5plugin, set HDF5_PLUGIN_PATH to the folder of the filter's plug-in, "
            "or write the file again with gzip, as h5repack -f GZIP=1 does where the filter is there",
        )


def _missing(used: list[int]) -> list[int]:
    return [number for number in used if not h5py.h5z.filter_avail(number)]


def refuse_other_kind(begin: bytes, path: Path) -> None:
    """Raises RecordingError for a file that begins as one of a known other kind."""
    for mark, (kind, remedy) in _OTHERS.items():
        if begin.startswith(mark):
            raise RecordingError("not an HDF5 file", where=str(path), why=f"It is {kind}", remedy=remedy)
