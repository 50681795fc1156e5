"""The fit tables of our recordings, read back."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

from platform_daemon.core.recordings.hdf5 import ANOTHER_COPY, Hdf5File, open_hdf5
from platform_daemon.core.recordings.header import FitTable
from platform_daemon.core.recordings.layout import FIT, LAYOUT, LAYOUT_ATTRIBUTE

TEXTS = ("parameters", "verdict", "reason")
TEXT = ("variant", "software_version")


def read_fits(path: Path | str) -> tuple[FitTable, ...]:
    """The fit tables of one of our recordings, by name; () if there are none.  Raises RecordingError."""
    with open_hdf5(path) as source:
        if source.attribute("/", LAYOUT_ATTRIBUTE) != LAYOUT:
            return ()
        return tuple(_read_fit(source, name) for name in source.names(FIT))


def _read_fit(source: Hdf5File, name: str) -> FitTable:
    found: dict[str, Any] = {"name": name}
    for entry in fields(FitTable):
        place = f"{FIT}/{name}/{entry.name}"
        if entry.name in TEXTS:
            found[entry.name] = source.texts(place)
        elif entry.name == "correction":  # only of fits that were corrected
            found[entry.name] = source.text(place) or ""
        elif entry.name in TEXT:
            found[entry.name] = source.text(place)
        elif entry.name != "name":
            found[entry.name] = source.values(place)
        if found[entry.name] is None:
            raise source.defect("missing", place, "a complete fit table", ANOTHER_COPY)
    return FitTable(**found)
