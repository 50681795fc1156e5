"""Angles of measured pendulums: HDF5 files with /time (n,) in s and /signal (1, n) in rad."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .even_clock import evened
from .hdf5 import Hdf5File, open_hdf5
from .time_column import even_stretch, fault_of, order_of
from .unit_conversion import conversion, is_dimensionless

_TIME, _SIGNAL = "/time", "/signal"
_MOST_SAMPLES = (0.01, 0.99)  # a spike is no swing
_PLAIN = ("1", "dimensionless")  # units without dimension in which an angle is in radians
_TURN = 2.0 * np.pi
_JUMP = 5.0  # usual steps by which a jump of the angle may differ from a turn
_FEWEST = 64  # samples in the longest even stretch


@dataclass(frozen=True)
class AngleSeries:
    """A series of angles with an even clock.

    Attributes:
        path: of the file.
        angle_rad: (1, n), the longest stretch with an even clock.
        sampling_rate_hz: of it.
        clock: holes in the time column, in words; empty if there are none.
        done: what was done to the samples, as sorting them by their times.
    """

    path: Path
    angle_rad: NDArray[np.float64]
    sampling_rate_hz: float
    clock: tuple[str, ...]
    done: tuple[str, ...] = ()
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
        bad = np.flatnonzero(~np.isfinite(time_s))
        if bad.size:
            what = f"holds {bad.size} values that are not finite, the first at sample {bad[0]}"
            raise source.defect(what, _TIME, "seconds", "correct the time column")
        sorting = order_of(time_s)
        if sorting is not None:
            time_s, angle_rad = time_s[sorting[0]], angle_rad[sorting[0]]
        fault = fault_of(time_s)
        if fault is not None:
            raise source.defect(fault[0], _TIME, "times that rise by one even step", fault[1])
        first, last, clock = even_stretch(time_s)
        if last - first < _FEWEST:
            what = f"is uneven: no {_FEWEST} samples in a row have the same step"
            raise source.defect(what, _TIME, "an even clock", "resample the data with a method of your choice")
        angle_rad, turning = unwrapped(angle_rad)
        _refuse_turns(source, angle_rad)
        even = evened(time_s[first:last], angle_rad[None, first:last], source.place(_TIME))
    done = ("" if sorting is None else sorting[1], turning, even.remark)
    return AngleSeries(path, even.samples, 1.0 / even.step_s, clock, tuple(each for each in done if each))


def _time(source: Hdf5File) -> NDArray[np.float64]:
    """(n,) s; from its first one on where it is a whole number, as of nanoseconds since 1970."""
    unit, _, since = source.units(_TIME).partition(" since ")
    values = source.values(_TIME)
    if values is None or values.ndim != 1 or values.size < 2 or values.dtype.kind == "c":
        seen = "missing" if values is None else f"has shape {values.shape}"
        raise source.defect(seen, _TIME, "a column of seconds")
    change = conversion(unit, "s") if since else source.conversion(_TIME, "s")
    if change is None:
        raise source.defect(f"has units {unit!r} since a date", _TIME, "a column of seconds", "convert it to seconds")
    counted = values.astype(np.int64) - np.int64(values[0]) if values.dtype.kind in "iu" else values
    return counted.astype(np.float64) * change.factor


def _angle(source: Hdf5File) -> NDArray[np.float64]:
    """(n,) rad."""
    values = source.values(_SIGNAL)
    rows = None if values is None else np.atleast_2d(values)
    if rows is None or rows.ndim != 2 or rows.shape[0] != 1 or rows.dtype.kind == "c":
        seen, remedy = _no_angle(values)
        raise source.defect(seen, _SIGNAL, "one angle, shape (1, n)", remedy)
    units = source.units(_SIGNAL)
    if units and is_dimensionless(units) and units.strip() not in _PLAIN:
        raise source.defect(f"is in {units!r}", _SIGNAL, "an angle in rad or deg", "convert it to an angle")
    if units:
        change = source.conversion(_SIGNAL, "rad")
    else:
        change = source.conversion("/", "rad")
    return np.asarray(rows[0] * change.factor, dtype=np.float64)


def _refuse_turns(source: Hdf5File, angle_rad: NDArray[np.float64]) -> None:
    """Raises RecordingError for values that no pendulum swings to."""
    what = turns_of(angle_rad)
    if what:
        expected = "less: at pi a pendulum is upside down, so these may be degrees"
        remedy = 'convert degrees to radians, or set the attribute units of /signal to "deg"; cut off what turns over'
        raise source.defect(what, _SIGNAL, expected, remedy)


def turns_of(angle_rad: NDArray[np.float64]) -> str:
    """What is seen of angles that no pendulum swings to, as degrees are; empty: they can be radians."""
    seen = angle_rad[np.isfinite(angle_rad)]
    lowest, highest = np.quantile(seen, _MOST_SAMPLES).tolist() if seen.size else (0.0, 0.0)
    beyond = highest - lowest > 2.0 * np.pi
    return f"goes from {seen.min():.4g} to {seen.max():.4g} rad, beyond pi to either side" if beyond else ""


def unwrapped(angle_rad: NDArray[np.float64]) -> tuple[NDArray[np.float64], str]:
    """(angles without jumps of one turn, what was done in words); unchanged, and empty, where there are none.

    Wrapped are values within one turn with steps of almost a whole one, which otherwise are a glitch, or degrees.
    angle_rad: (.., n).
    """
    steps = np.diff(angle_rad, axis=-1)
    jumps = np.abs(steps) > np.pi
    if not jumps.any() or not np.isfinite(angle_rad).all() or np.ptp(angle_rad) > _TURN * (1.0 + 1e-6):
        return angle_rad, ""
    usual = float(np.quantile(np.abs(steps[~jumps]), _MOST_SAMPLES[1])) if not jumps.all() else np.inf
    if np.abs(np.abs(steps[jumps]) - _TURN).max() > min(_JUMP * usual, 0.5 * np.pi):
        return angle_rad, ""
    count = np.count_nonzero(jumps)
    return np.unwrap(angle_rad, axis=-1), f"the angle jumped by a whole turn at {count} samples; the turns were undone"


def _no_angle(values: NDArray[np.generic] | None) -> tuple[str, str]:
    """(what is seen in its place, a remedy)."""
    if values is None:
        return "missing", "write the angle to it"
    seen = f"has shape {values.shape}"
    if values.dtype.kind == "c":
        return f"{seen} of complex numbers", "write the angle as real numbers"
    if values.ndim != 2:
        return seen, "write one angle, a row of numbers"
    if values.shape[1] == 1:
        return seen, "transpose it"
    return (
        f"{seen}: {min(values.shape)} channels",
        "write every channel that is an angle to a file of its own, with /time",
    )
