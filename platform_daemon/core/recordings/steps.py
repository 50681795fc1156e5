"""`/step`: which step of a procedure each frame belongs to, what it was made with, and its own windows."""

from __future__ import annotations

from collections.abc import Sequence

import h5py
import numpy as np

from .datasets import group, put, put_texts
from .hdf5 import ANOTHER_COPY, Hdf5File
from .layout import STEP, STEP_VALUES
from .recording import FrameStep, SequenceInfo, StepLabel
from .units import unit_of

_WINDOWS = ("tx_samples", "switch_samples", "rx_samples")


def write_steps(h5: h5py.File, steps: Sequence[FrameStep | None]) -> None:
    """One entry per frame; nothing if no frame belongs to a step.  A value that a step has not is NaN or ""."""
    if all(step is None for step in steps):
        return
    made = group(h5, STEP, "NXcollection")
    put(made, "number", np.array([0 if s is None else s.label.number for s in steps]), units="1")
    for name in _WINDOWS:
        put(made, name, np.array([0 if s is None else getattr(s, name) for s in steps]), units="samples")
    if any(step is not None and step.label.name for step in steps):
        put_texts(made, "name", ("" if s is None else s.label.name for s in steps))
    values = group(h5, STEP_VALUES, "NXcollection")
    labels = [{} if s is None else s.label.values for s in steps]
    for key in dict.fromkeys(key for label in labels for key in label):
        column = [label.get(key) for label in labels]
        if any(isinstance(v, str) for v in column):
            put_texts(values, key, ("" if v is None else str(v) for v in column))
        else:
            put(values, key, np.array([np.nan if v is None else v for v in column], float), units=unit_of(key))


def read_steps(source: Hdf5File, frames: int) -> tuple[FrameStep | None, ...]:
    """The step of every frame.  Raises RecordingError if a column is missing or has another length."""
    if not source.has_group(STEP):
        return (None,) * frames
    numbers = [_whole(source, name, frames) for name in ("number", *_WINDOWS)]
    names = source.texts(f"{STEP}/name") or ("",) * frames  # earlier versions wrote none
    if len(names) != frames:
        raise source.defect("of another length", f"{STEP}/name", f"one entry for each of {frames}", ANOTHER_COPY)
    values = {key: _column(source, key, frames) for key in source.names(STEP_VALUES)}
    found: list[FrameStep | None] = []
    for k in range(frames):
        number, tx, switch, rx = (int(column[k]) for column in numbers)
        # A number that is not one, and an empty text: this step was not made with that key.
        label = {key: column[k] for key, column in values.items() if column[k] == column[k] and column[k] != ""}
        found.append(FrameStep(StepLabel(number, label, names[k]), tx, switch, rx) if number else None)
    return tuple(found)


def common_windows(sequences: Sequence[SequenceInfo]) -> SequenceInfo:
    """Windows that hold every frame, with RX beginning at the same sample in all."""
    first = max(sequences, key=lambda s: s.rx_start)
    return SequenceInfo(
        first.base_frequency_hz,
        first.decimation,
        first.tx_samples,
        first.switch_samples,
        max(s.rx_samples for s in sequences),
    )


def _whole(source: Hdf5File, name: str, frames: int) -> list[int]:
    path = f"{STEP}/{name}"
    found = source.values(path, "1")
    if found is None or found.shape != (frames,) or found.dtype.kind not in "iu" or found.min(initial=0) < 0:
        raise source.defect("missing or of another shape", path, f"{frames} counts", ANOTHER_COPY)
    return [int(value) for value in found]


def _column(source: Hdf5File, key: str, frames: int) -> list[float] | list[str]:
    path = f"{STEP_VALUES}/{key}"
    shape = source.shape(path)
    numbers = shape is not None and shape[1].kind == "f"
    found = source.values(path, unit_of(key)) if numbers else source.texts(path)
    if found is None or len(found) != frames:
        raise source.defect("missing or of another length", path, f"one entry for each of {frames}", ANOTHER_COPY)
    return [float(value) for value in found] if numbers else [str(value) for value in found]
