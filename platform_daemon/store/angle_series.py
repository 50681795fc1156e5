"""Angles of measured pendulums: HDF5 files with /time (n,) in s and /signal (1, n) in rad."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .hdf5 import Hdf5File, open_hdf5

_TIME, _SIGNAL = "/time", "/signal"
_UNEVEN = 0.25  # of a step: a step that differs more is a gap
_FEWEST = 64  # samples in the longest even stretch
_LISTED = 4  # gaps told one by one
_DEGREES = ("deg", "degree", "degrees", "°")
_RADIANS = ("", "rad", "radian", "radians", "1")


@dataclass(frozen=True)
class AngleSeries:
    """A series of angles with an even clock.

    Attributes:
        path: of the file.
        angle_rad: (1, n), the longest stretch with an even clock.
        sampling_rate_hz: of it.
        clock: what is wrong with the time column, in words; empty if nothing is.
    """

    path: Path
    angle_rad: NDArray[np.float64]
    sampling_rate_hz: float
    clock: tuple[str, ...]
    frames: int = 1

    @property
    def finite(self) -> bool:
        """All samples are numbers."""
        return bool(np.isfinite(self.angle_rad).all())


def is_time_series(path: Path) -> bool:
    """Does the file hold /time and /signal instead of a recording?  Raises RecordingError if it cannot be opened."""
    with open_hdf5(path) as source:
        return {"time", "signal"} <= set(source.names("/"))


def read_angles(path: Path) -> AngleSeries:
    """Raises RecordingError naming file, HDF5 path, what was expected and a remedy."""
    with open_hdf5(path) as source:
        time_s, angle_rad = _time(source), _angle(source)
        if time_s.size != angle_rad.size:
            what = f"has {angle_rad.size} samples, /time has {time_s.size}"
            raise source.defect(what, _SIGNAL, "as many as /time", "record again")
        if not np.isfinite(time_s).all():
            raise source.defect("holds values that are not finite", _TIME, "seconds", "correct the time column")
        first, last, step_s, clock = _even_stretch(time_s)
        if last - first < _FEWEST:
            what = f"is uneven: no {_FEWEST} samples in a row have the same step"
            raise source.defect(what, _TIME, "an even clock", "resample the data with a method of your choice")
    return AngleSeries(path, angle_rad[None, first:last], 1.0 / step_s, clock)


def _time(source: Hdf5File) -> NDArray[np.float64]:
    """(n,) s."""
    values = source.values(_TIME)
    if values is None or values.ndim != 1 or values.size < 2 or values.dtype.kind == "c":
        seen = "missing" if values is None else f"has shape {values.shape}"
        raise source.defect(seen, _TIME, "a column of seconds")
    return values.astype(np.float64)


def _angle(source: Hdf5File) -> NDArray[np.float64]:
    """(n,) rad."""
    values = source.values(_SIGNAL)
    rows = None if values is None else np.atleast_2d(values)
    if rows is None or rows.ndim != 2 or rows.shape[0] != 1 or rows.dtype.kind == "c":
        seen = "missing" if values is None else f"has shape {values.shape}"
        raise source.defect(seen, _SIGNAL, "one angle, shape (1, n)")
    unit = source.attribute(_SIGNAL, "units") or source.attribute("/", "units") or ""
    known = str(unit).strip().lower()
    if known not in (*_RADIANS, *_DEGREES):
        raise source.defect(f"has units {unit!r}", _SIGNAL, "rad or deg", "convert the angle to radians")
    return np.asarray(np.radians(rows[0]) if known in _DEGREES else rows[0], dtype=np.float64)


def _even_stretch(time_s: NDArray[np.float64]) -> tuple[int, int, float, tuple[str, ...]]:
    """(first, last + 1 sample of the longest stretch with an even clock, its mean step in s, the gaps in words)."""
    steps = np.diff(time_s)
    usual = float(np.median(steps))
    if usual <= 0.0:
        return 0, 0, 1.0, ()
    gaps = np.flatnonzero(np.abs(steps - usual) > _UNEVEN * usual)
    ends = np.concatenate([[-1], gaps, [time_s.size - 1]])
    longest = int(np.argmax(np.diff(ends)))
    first, last = int(ends[longest]) + 1, int(ends[longest + 1]) + 1
    step_s = (time_s[last - 1] - time_s[first]) / max(last - 1 - first, 1)
    return first, last, float(step_s), _gaps_in_words(steps / usual, gaps, first, last)


def _gaps_in_words(steps: NDArray[np.float64], gaps: NDArray[np.int64], first: int, last: int) -> tuple[str, ...]:
    """steps: (n - 1,) in units of the usual one."""
    if not gaps.size:
        return ()
    used = f"only samples {first} to {last - 1}, the longest even stretch, are used"
    told = [f"the time column goes on by {steps[g]:.4g} steps before sample {g + 1}; {used}" for g in gaps[:_LISTED]]
    more = gaps.size - _LISTED
    return (*told, f"and {more} further uneven steps in the time column") if more > 0 else tuple(told)
