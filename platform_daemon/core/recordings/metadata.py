"""Reads what only our own files carry: the per-frame columns, the excitation and where it all comes from.

In our own layout next to nothing is optional, so anything missing means damage.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from platform_daemon.core.schemas.base import ClockKind

from .hdf5 import ANOTHER_COPY, Hdf5File
from .layout import ENTRY, EXCITATION, FLAGS, FRAMES, VERDICTS
from .recording import Excitation, FrameInfo, Provenance
from .steps import read_steps
from .value_sources import read_value_sources, sources_step

_SAMPLE = f"{ENTRY}/sample/name"
_OPERATOR = f"{ENTRY}/operator/name"
_SCALARS = (
    ("requested_frequency", "Hz"),
    ("realised_frequency", "Hz"),
    ("field", "T"),
    ("periods", "1"),
    ("phase", "rad"),
)


def read_frame_info(source: Hdf5File, frames: int, samples: int) -> tuple[FrameInfo, ...]:
    """The record of every frame.  Raises RecordingError if a column is missing or has another length."""
    flags = {name: _column(source, f"{FRAMES}/{name}", frames) for name in (*FLAGS, "blank")}
    joined = source.has_dataset(f"{FRAMES}/joined")
    flags["joined"] = _column(source, f"{FRAMES}/joined", frames) if joined else np.zeros(frames)
    late_known = source.has_dataset(f"{FRAMES}/late")
    late = _column(source, f"{FRAMES}/late", frames, unit="s", nan=True) if late_known else np.full(frames, np.nan)
    shot, valid = (_column(source, f"{FRAMES}/{name}", frames) for name in ("shot", "valid_samples"))
    clock = _column(source, f"{FRAMES}/monotonic", frames, unit="s", nan=True)
    celsius = _column(source, f"{FRAMES}/temperature", frames, unit="degC", nan=True)
    texts = ("time_stamp", "verdict", "reason")
    stamp, verdict, reason = (_texts(source, f"{FRAMES}/{name}", frames) for name in texts)
    excitation, steps = _excitation(source, frames), read_steps(source, frames)
    if not set(verdict) <= set(VERDICTS) or valid.min() < 0 or valid.max() > samples:
        expected = f"verdicts {' or '.join(VERDICTS)}, valid_samples from 0 to {samples}"
        raise source.defect("a frame contradicts the layout", FRAMES, expected, ANOTHER_COPY)
    return tuple(
        FrameInfo(
            shot=int(shot[k]),
            valid_samples=int(valid[k]),
            verdict=verdict[k],
            reason=reason[k],
            time_stamp=stamp[k] or None,
            monotonic_s=_known(clock[k]),
            temperature_c=_known(celsius[k]),
            late_s=_known(late[k]),
            excitation=excitation[k],
            step=steps[k],
            **{name: bool(column[k]) for name, column in flags.items()},
        )
        for k in range(frames)
    )


def read_provenance(source: Hdf5File) -> Provenance:
    """Title, sample, people, software, configuration.  Raises RecordingError if one is missing."""
    names, identities = (_texts(source, f"{ENTRY}/devices/{name}") for name in ("role", "identity"))
    planned = source.number(f"{ENTRY}/planned_shots", "1")
    return Provenance(
        series_id=_text(source, f"{ENTRY}/entry_identifier"),
        title=_text(source, f"{ENTRY}/title"),
        start_time=_text(source, f"{ENTRY}/start_time"),
        sample_name=_text(source, _SAMPLE),
        operator=_text(source, _OPERATOR),
        comment=_text(source, f"{ENTRY}/comment/data"),
        platform=_text(source, f"{ENTRY}/platform"),
        software_version=_text(source, f"{ENTRY}/program_version"),
        channel_names=_texts(source, f"{ENTRY}/channel_names"),
        devices=dict(zip(names, identities, strict=False)),
        planned_shots=None if planned is None else int(planned),
        incomplete=source.text(f"{ENTRY}/incomplete"),
        value_sources=read_value_sources(source),
        sources_step=sources_step(source),
        clock=_clock(source),
    )


def _clock(source: Hdf5File) -> ClockKind | None:
    match source.text(f"{ENTRY}/clock"):
        case None:
            return None  # an earlier version wrote the file
        case "real":
            return "real"
        case "simulated":
            return "simulated"
        case other:
            raise source.defect(f"is {other!r}", f"{ENTRY}/clock", "real or simulated", ANOTHER_COPY)


def _excitation(source: Hdf5File, frames: int) -> tuple[Excitation | None, ...]:
    if not source.has_group(EXCITATION):
        return (None,) * frames
    scalars = [_column(source, f"{EXCITATION}/{n}", frames, unit=unit, nan=True) for n, unit in _SCALARS]
    axis, current = (
        _column(source, f"{EXCITATION}/{n}", frames, unit=unit, ndim=2, nan=True)
        for n, unit in (("axis", "1"), ("current", "A"))
    )
    waveform = _texts(source, f"{EXCITATION}/waveform", frames)
    if axis.shape[1] != 3:
        raise source.defect(f"has shape {axis.shape}", f"{EXCITATION}/axis", f"({frames}, 3)", ANOTHER_COPY)
    found: list[Excitation | None] = []
    for k in range(frames):
        requested, realised, field, periods, phase = (float(column[k]) for column in scalars)
        row = Excitation(waveform[k], requested, realised, field, axis[k], periods, phase, current[k])
        numbers = np.concatenate([[requested, realised, field, periods, phase], axis[k], current[k]])
        if waveform[k] and not np.isfinite(numbers).all():
            raise source.defect(f"frame {k} is not finite", EXCITATION, "finite numbers", ANOTHER_COPY)
        found.append(row if waveform[k] else None)
    return tuple(found)


def _column(
    source: Hdf5File, name: str, frames: int, *, unit: str = "1", ndim: int = 1, nan: bool = False
) -> NDArray[np.float64]:
    found = source.values(name, unit)
    if found is None or found.ndim != ndim or len(found) != frames or found.dtype.kind == "c":
        raise source.defect("missing or of another shape", name, f"one entry for each of {frames} frames", ANOTHER_COPY)
    if not nan and not np.isfinite(found).all():
        raise source.defect("not finite", name, "finite numbers", ANOTHER_COPY)
    return found.astype(np.float64)


def _texts(source: Hdf5File, name: str, count: int | None = None) -> tuple[str, ...]:
    found = source.texts(name)
    if found is None or (count is not None and len(found) != count):
        raise source.defect("missing or of another length", name, f"{count or 'some'} texts", ANOTHER_COPY)
    return found


def _text(source: Hdf5File, name: str) -> str:
    found = source.text(name)
    if found is None:
        raise source.defect("missing", name, "a text", ANOTHER_COPY)
    return found


def _known(value: float) -> float | None:
    # NaN stands for "no sensor" on disk, because HDF5 has no null; it must not leak into JSON.
    return float(value) if np.isfinite(value) else None
