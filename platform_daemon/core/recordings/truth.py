"""What the simulator knows about its own shots: written with them, read by demonstrations and tests only.

Apart from the reader on purpose: nothing that estimates or diagnoses may import this module.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from drivers.errors import RecordingError

from .hdf5 import open_hdf5
from .layout import LAYOUT, LAYOUT_ATTRIBUTE, SIMULATION
from .units import unit_of

_JSON = f"{SIMULATION}/json"
_VALUES = f"{SIMULATION}/values"
TRUTH_COLUMNS = (SIMULATION, _VALUES)
"""Groups of data sets with one entry per frame."""


def read_truth(path: Path | str) -> list[dict[str, Any]] | None:
    """The truth of every frame ({} for one without); None if the file carries none or is not ours.

    Raises RecordingError.
    """
    with open_hdf5(path) as source:
        if source.attribute("/", LAYOUT_ATTRIBUTE) != LAYOUT or not source.has_group(SIMULATION):
            return None
        texts = source.texts(_JSON)
        if texts is None:
            raise source.defect("missing", _JSON, "one JSON text per frame")
        return [_parsed(text, source.place(_JSON)) for text in texts]


def _parsed(text: str, where: str) -> dict[str, Any]:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise RecordingError("not a JSON object", where=where, remedy="use another copy of the file")
    return found


def write_truth(h5: h5py.File, truths: Sequence[Mapping[str, Any] | None]) -> None:
    """`/simulation`: one JSON text per frame, and each number in it as a column of `/simulation/values`.

    Writes nothing if no frame has a truth.  Numbers that are not finite become null: JSON has no NaN.
    """
    if all(truth is None for truth in truths):
        return
    plain = [_plain(truth or {}) for truth in truths]
    made = h5.create_group(SIMULATION)
    made.attrs["NX_class"] = "NXcollection"
    texts = [json.dumps(p, ensure_ascii=True) for p in plain]
    h5.create_dataset(_JSON, data=np.array(texts, object), dtype=h5py.string_dtype(), track_times=False)
    values = h5.create_group(_VALUES)
    values.attrs["NX_class"] = "NXcollection"
    numbers = [dict(_numbers(p)) for p in plain]
    for name in sorted({name for row in numbers for name in row}):
        column = values.create_dataset(name, data=[row.get(name, math.nan) for row in numbers], track_times=False)
        column.attrs["units"] = unit_of(name)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, str | int | None) else str(value)


def _numbers(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    """Numbers by dotted name; names that are no HDF5 link names stay in the JSON only."""
    for key, value in table.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            yield from _numbers(value, f"{name}.")
        elif isinstance(value, int | float) and name.isascii() and all(part.isidentifier() for part in name.split(".")):
            with suppress(OverflowError):  # an integer beyond float stays in the JSON only
                yield name, float(value)
