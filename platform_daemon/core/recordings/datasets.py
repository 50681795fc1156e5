"""Groups and datasets as all files have them: numbers with their units, text that every reader accepts."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import h5py
import numpy as np


def group(h5: h5py.Group, name: str, nx_class: str) -> h5py.Group:
    """A new group with its NeXus class."""
    made = h5.create_group(name)
    made.attrs["NX_class"] = nx_class
    return made


def put(h5: h5py.Group, name: str, value: Any, units: str | None = None, long_name: str = "", **filters: Any) -> None:
    """A dataset: text as variable-length UTF-8, anything else as the numpy type it has."""
    if isinstance(value, str):
        value = clean(value)
    made = h5.create_dataset(name, data=value, track_times=False, **filters)
    if units is not None:
        made.attrs["units"] = units
    if long_name:
        made.attrs["long_name"] = long_name


def put_texts(h5: h5py.Group, name: str, values: Iterable[str]) -> None:
    """A list of variable-length UTF-8 strings; may be empty."""
    texts = [clean(v) for v in values]
    h5.create_dataset(name, data=np.array(texts, object), dtype=h5py.string_dtype(), track_times=False)


def clean(text: str) -> str:
    """`text` without what HDF5 strings cannot hold (NUL, lone surrogates): a shot is not lost over a comment."""
    return text.replace("\0", "\ufffd").encode("utf-8", "replace").decode("utf-8")
