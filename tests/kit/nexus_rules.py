"""The NeXus rules that make a generic viewer show a file at once; each returns what it finds wrong."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py


def violations(path: Path) -> list[str]:
    """Everything in the file that breaks one of the six rules."""
    with h5py.File(path) as h5:
        found = [*_default_chain(h5), *_classes(h5)]
        for data in _of_class(h5, "NXdata"):
            found += [*_signal(data), *_axes(data), *_units(data)]
        return found


def _text(value: Any) -> Any:
    return value.decode() if isinstance(value, bytes) else value


def _default_chain(h5: h5py.File) -> Iterator[str]:
    """1. @default leads from the root over an NXentry to an NXdata."""
    here: Any = h5
    for expected in ("NXentry", "NXdata"):
        name = _text(here.attrs.get("default"))
        if name not in here or _text(here[name].attrs.get("NX_class")) != expected:
            yield f"{here.name}@default = {name!r} names no {expected}"
            return
        here = here[name]


def _classes(h5: h5py.File) -> Iterator[str]:
    """2. Every group has an NX_class, the root NXroot; 3. an NXentry has a title and a start_time."""
    groups = [h5]
    h5.visititems(lambda _, item: groups.append(item) if isinstance(item, h5py.Group) else None)
    for group in groups:
        if not str(_text(group.attrs.get("NX_class", ""))).startswith("NX"):
            yield f"{group.name} has no NX_class"
    if _text(h5.attrs.get("NX_class")) != "NXroot":
        yield "the root is no NXroot"
    for entry in _of_class(h5, "NXentry"):
        yield from (f"{entry.name} has no {name}" for name in ("title", "start_time") if name not in entry)


def _of_class(h5: h5py.File, name: str) -> list[h5py.Group]:
    found: list[h5py.Group] = []
    h5.visititems(lambda _, item: found.append(item) if _text(item.attrs.get("NX_class")) == name else None)
    return found


def _signal(data: h5py.Group) -> Iterator[str]:
    """4. @signal names a dataset."""
    name = _text(data.attrs.get("signal"))
    if name not in data or not isinstance(data[name], h5py.Dataset):
        yield f"{data.name}@signal = {name!r} names no dataset"


def _axes(data: h5py.Group) -> Iterator[str]:
    """5. @axes has one name per dimension of the signal, and each axis the length of its dimension."""
    shape = data[data.attrs["signal"]].shape
    axes = [_text(a) for a in data.attrs["axes"]]
    if len(axes) != len(shape):
        yield f"{data.name}: {len(axes)} axes for {len(shape)} dimensions"
    for name, length in zip(axes, shape, strict=False):
        if name != "." and (name not in data or data[name].shape != (length,)):
            yield f"{data.name}/{name} has not length {length}"


def _units(data: h5py.Group) -> Iterator[str]:
    """6. Signal and axes carry @units."""
    for name, item in data.items():
        if "units" not in item.attrs:
            yield f"{data.name}/{name} has no units"
