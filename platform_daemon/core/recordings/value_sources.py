"""`/entry/value_sources`: where the values of the sequence come from, a dataset with attributes for each of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import h5py
import numpy as np
from pydantic import ValidationError

from platform_daemon.core.schemas.value_sources import ValueSource

from .datasets import clean, group, put
from .hdf5 import ANOTHER_COPY, Hdf5File
from .layout import VALUE_SOURCES
from .recording import Recording
from .units import unit_of

_TEXTS = ("source", "job", "date", "path")


def write_value_sources(h5: h5py.File, sources: Sequence[ValueSource], step: int | None) -> None:
    """One dataset per value; nothing without sources.  step: number of the step that they hold for, None: all."""
    if not sources:
        return
    made = group(h5, VALUE_SOURCES, "NXcollection")
    if step is not None:
        made.attrs["step"] = np.int64(step)
    for each in sources:
        vector = isinstance(each.value, tuple)  # as text: a direction of numbers would need a dimension of its own
        value = ",".join(f"{x:.9g}" for x in each.value) if vector else each.value  # type: ignore[union-attr]
        units = None if isinstance(value, str) else unit_of(each.quantity)
        put(made, each.quantity, value, units=units)
        for name in _TEXTS:
            if (said := getattr(each, name)) is not None:
                made[each.quantity].attrs[name] = clean(said)


def read_value_sources(source: Hdf5File) -> tuple[ValueSource, ...]:
    """In the order of their names; none in files of earlier versions.  Raises RecordingError for a damaged one."""
    return tuple(_read(source, name) for name in source.names(VALUE_SOURCES))


def sources_of_frames(recording: Recording, frames: Iterable[int]) -> tuple[ValueSource, ...]:
    """Those of these frames; () if the file says them of another step only, or not at all."""
    said = recording.provenance
    if said is None:
        return ()
    steps = {None if (step := recording.frame_info[k].step) is None else step.label.number for k in frames}
    return said.value_sources if steps <= {said.sources_step} else ()


def sources_step(source: Hdf5File) -> int | None:
    """The step that they hold for; None: the whole recording, or there are none."""
    found = source.attribute(VALUE_SOURCES, "step") if source.has_group(VALUE_SOURCES) else None
    return int(found) if isinstance(found, int | np.integer) else None


def _read(source: Hdf5File, name: str) -> ValueSource:
    place = f"{VALUE_SOURCES}/{name}"
    shape = source.shape(place)
    numbers = shape is not None and shape[1].kind in "iuf"
    found = source.number(place, unit_of(name)) if numbers else source.text(place)
    said = {key: source.attribute(place, key) for key in _TEXTS}
    try:
        return ValueSource.model_validate({"quantity": name, "value": found, **said})
    except ValidationError:
        raise source.defect("does not say where it comes from", place, "a value and its source", ANOTHER_COPY) from None
