"""Samples whose stamps leave an even clock, as those of a clock that drifts or steps that scatter, put on an even one.

Analyses know one sampling rate.  Stamps that stray from the best even clock (the line of least squares through stamp
against number) by more than their rounding and by more than a thousandth of a step are followed: the samples are
interpolated at even times by a spline of fifth degree.  Two things must be kept apart from that: stamps that are
rounded, and stamps that scatter while the samples are even, as a computer writes them that was busy; samples that are
smoother if they are taken as even do not follow such stamps.  Where scatter and a drift come together the stamps are
followed: their scatter makes the errors of a fit larger, and a drift that is guessed would make it wrong.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError

Floats = NDArray[np.float64]
_MATTERS = 1e-3  # of a step
_FEWEST_PER_PERIOD = 6.0  # samples; a spline through fewer is no signal
_DEGREE = 5
_ROUGH = 4  # differences in a row: a swing nearly vanishes in them, noise does not
_SMOOTHER = 0.7  # roughness of the samples as they are over that at their stamps: they do not follow these
_HALF_UNIT = 0.52  # of the last digit: by how much rounding moves a stamp, and what arithmetic adds
_STRETCHES = 500
_PIECES = 16  # cubics of the slow part of the deviation
_LOOKED_AT = 2000  # stamps whose digits are counted
_MOST_DIGITS = 15  # a number of 64 bits holds no more
_UNITS = (1.0, 60.0, 3600.0, 86400.0, 1e-3, 1e-6, 1e-9)  # s, in which a file may have written its stamps


class Evened(NamedTuple):
    """Samples of an even clock.  samples: (.., n); step_s: of it; remark: what was done, in words, or empty."""

    samples: Floats
    step_s: float
    remark: str = ""


def evened(time_s: Floats, samples: Floats, where: str) -> Evened:
    """The samples on an even clock.

    time_s: (n,), rising, n >= 64, without holes.  samples: (.., n); those that hold no finite numbers are left as they
    are.  Raises RecordingError for stamps that must be followed and samples too coarse to be interpolated.
    """
    n = time_s.size
    step_s = float(time_s[-1] - time_s[0]) / (n - 1)
    left = deviation_s(time_s)
    most = float(np.abs(left).max())
    if most <= _MATTERS * step_s or _is_rounding(left, rounding_s(time_s)) or not np.isfinite(samples).all():
        return Evened(samples, _step_of_line(time_s))
    _refuse_coarse(samples, most, step_s, where)
    told = f"the times leave an even clock by up to {1e3 * most:.3g} ms, {most / step_s:.2g} of a step"
    found = _interpolated(time_s, samples)
    if _is_scatter(left) and _roughness(samples) < _SMOOTHER * _roughness(found.samples):
        remark = f"{told}, but the samples are smoother without that, and were taken as even"
        return Evened(samples, _step_of_line(time_s), remark)
    return found._replace(remark=f"{told}; the samples were interpolated at even times")


def deviation_s(time_s: Floats) -> Floats:
    """(n,) how far each stamp is after the line of least squares through all."""
    number = np.arange(time_s.size) - 0.5 * (time_s.size - 1)
    since = time_s - time_s[0]
    centred = since - since.mean()
    return np.asarray(centred - number * float(number @ centred / (number @ number)), dtype=np.float64)


def _step_of_line(time_s: Floats) -> float:
    number = np.arange(time_s.size) - 0.5 * (time_s.size - 1)
    return float(number @ (time_s - time_s[0]) / (number @ number))


def rounding_s(time_s: Floats) -> float:
    """One unit of the last digit with which the stamps are written, s: decimals, digits that count, or 32 bits."""
    seen = time_s[np.linspace(0, time_s.size - 1, min(time_s.size, _LOOKED_AT)).astype(np.intp)]
    found = float(np.spacing(np.abs(seen).max()))
    for unit in _UNITS:
        number = seen / unit
        found = max(found, unit * max(_decimal(number), _significant(number), _single(number)))
    return found


def _same(a: Floats, b: Floats) -> bool:
    return bool((np.abs(a - b) <= 4.0 * np.spacing(np.maximum(np.abs(a), np.abs(b)))).all())


def _decimal(number: Floats) -> float:
    for places in range(_MOST_DIGITS):
        if _same(number, np.round(number, places)):
            return float(10.0**-places)
    return 0.0


def _significant(number: Floats) -> float:
    """Of the largest number."""
    size = np.floor(np.log10(np.where(number == 0.0, 1.0, np.abs(number))))
    mantissa = number / 10.0**size
    for places in range(_MOST_DIGITS - 1):
        rounded = np.round(mantissa, places)
        if (np.abs(mantissa - rounded) <= 1e-14 * np.abs(mantissa)).all():
            return float(10.0 ** (size.max() - places))
    return 0.0


def _single(number: Floats) -> float:
    with np.errstate(over="ignore"):
        short = number.astype(np.float32)
    return float(np.spacing(np.abs(short).max())) if _same(number, short.astype(np.float64)) else 0.0


def _interpolated(time_s: Floats, samples: Floats) -> Evened:
    """At as many even times from the first stamp to the last."""
    from scipy.interpolate import make_interp_spline

    since = time_s - time_s[0]
    even = np.linspace(0.0, since[-1], since.size)
    spline = make_interp_spline(since, samples, k=_DEGREE, axis=-1)
    return Evened(np.asarray(spline(even), dtype=np.float64), float(since[-1]) / (since.size - 1))


def _slow_part(left: Floats) -> Floats:
    from scipy.interpolate import make_lsq_spline

    number = np.arange(left.size, dtype=np.float64)
    ends = np.linspace(0.0, number[-1], _PIECES + 1)
    knots = np.concatenate([np.repeat(ends[0], 3), ends, np.repeat(ends[-1], 3)])
    return np.asarray(make_lsq_spline(number, left, knots, k=3)(number), dtype=np.float64)


def _is_scatter(left: Floats) -> bool:
    """Its slow part is no larger than scatter alone leaves there."""
    slow = _slow_part(left)
    by_chance = float(np.std(left - slow)) * np.sqrt((_PIECES + 3) / slow.size)
    return bool(np.std(slow) < 2.0 * by_chance)


def _is_rounding(left: Floats, unit_s: float) -> bool:
    """Is there any even clock of which these stamps are, rounded or cut to this unit?

    All of them are within half a unit of some line, then, which need not be that of least squares; the line for which
    the largest distance is least tells, found for the farthest stamps of each stretch.
    """
    from scipy.optimize import linprog

    most = float(np.abs(left).max())
    if most <= 0.5 * unit_s or most > 2.0 * unit_s:
        return most <= 0.5 * unit_s
    edges = np.linspace(0, left.size, min(left.size, _STRETCHES) + 1).astype(np.intp)
    far = [lo + pick(left[lo:hi]) for lo, hi in pairwise(edges) for pick in (np.argmin, np.argmax)]
    place, value = np.array(far) / left.size, left[far] / unit_s
    ones = np.ones(place.size)
    upper = np.column_stack([-ones, -place, -ones])  # value - (a + b place) <= distance
    lower = np.column_stack([ones, place, -ones])
    limits = np.concatenate([-value, value])
    line = linprog([0.0, 0.0, 1.0], A_ub=np.vstack([upper, lower]), b_ub=limits, bounds=(None, None))
    return line.fun is not None and bool(line.fun <= _HALF_UNIT)


def _roughness(samples: Floats) -> float:
    return float(np.sqrt(np.mean(np.diff(samples, _ROUGH, axis=-1) ** 2)))


def _refuse_coarse(samples: Floats, most_s: float, step_s: float, where: str) -> None:
    """Raises RecordingError for fewer samples in a period of the strongest oscillation than a spline needs."""
    n = samples.shape[-1]
    rows = samples.reshape(-1, n)
    line = np.linspace(-1.0, 1.0, n)
    bare = rows - rows.mean(axis=-1, keepdims=True) - (rows @ line / (line @ line))[:, None] * line
    power = (np.abs(np.fft.rfft(bare * np.hanning(n), axis=-1)) ** 2).sum(axis=0)
    per_period = n / max(int(power.argmax()), 1)
    if per_period >= _FEWEST_PER_PERIOD:
        return
    raise RecordingError(
        f"the times leave an even clock by up to {1e3 * most_s:.3g} ms, {most_s / step_s:.2g} of a step",
        where=where,
        why=f"the strongest oscillation has {per_period:.2g} samples a period, too few to interpolate at even times",
        remedy=f"sample at an even rate, or with more than {_FEWEST_PER_PERIOD:.0f} samples a period",
    )
