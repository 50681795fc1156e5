"""Samples whose stamps leave an even clock, as those of a clock that drifts or steps that scatter, put on an even one.

Analyses know one sampling rate.  Stamps that stray from the best even clock (the line of least squares through stamp
against number) by more than their rounding and by more than a thousandth of a step are followed: the samples are
interpolated at even times by a spline of fifth degree.  Two things must be kept apart from that: stamps that are
rounded, and stamps that scatter while the samples are even, as a computer writes them that was busy; samples that are
smoother without the scatter of their stamps do not follow it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError

Floats = NDArray[np.float64]
_MATTERS = 1e-3  # of a step
_FEWEST_PER_PERIOD = 6.0  # samples; a spline through fewer is no signal
_DEGREE = 5
_ROUGH = 4  # differences in a row: a swing nearly vanishes in them, noise does not
_SMOOTHER = 0.7  # roughness without the scatter of the stamps over that with it: the samples do not follow the scatter
_WINDOWS = 8  # of the slow part of the deviation; cubics, so about 24 parameters
_SLOW_PARAMETERS = 24
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
    least = max(rounding_s(time_s), _MATTERS * step_s)
    most = float(np.abs(left).max())
    if most <= least or not np.isfinite(samples).all():
        return Evened(samples, _step_of_line(time_s))
    _refuse_coarse(samples, most, step_s, where)
    told = f"the times leave an even clock by up to {1e3 * most:.3g} ms, {most / step_s:.2g} of a step"
    slow = _slow_part(left)
    follows = _interpolated(time_s, samples)
    smooth = _interpolated(time_s - left + slow, samples) if float(np.abs(slow).max()) > least else Evened(samples, 0.0)
    if _roughness(smooth.samples) >= _SMOOTHER * _roughness(follows.samples):
        return follows._replace(remark=f"{told}; the samples were interpolated at even times")
    scatter = f"{told}, and the samples do not follow their scatter, being smoother without it"
    if smooth.step_s == 0.0 or _is_chance(slow, left - slow):
        return Evened(samples, _step_of_line(time_s), f"{scatter}: they were taken as even")
    return smooth._replace(remark=f"{scatter}: they were interpolated at even times by the slow drift alone")


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
    from scipy.signal import savgol_filter

    return np.asarray(savgol_filter(left, max(left.size // _WINDOWS, 8) | 1, 3), dtype=np.float64)


def _is_chance(slow: Floats, scatter: Floats) -> bool:
    """Scatter alone leaves as much in the slow part."""
    by_chance = float(np.std(scatter)) * np.sqrt(_SLOW_PARAMETERS / slow.size)
    return bool(np.std(slow) < 2.0 * by_chance)


def _roughness(samples: Floats) -> float:
    return float(np.sqrt(np.mean(np.diff(samples, _ROUGH, axis=-1) ** 2)))


def _refuse_coarse(samples: Floats, most_s: float, step_s: float, where: str) -> None:
    """Raises RecordingError for fewer samples in a period of the strongest oscillation than a spline needs."""
    n = samples.shape[-1]
    rows = samples.reshape(-1, n)
    ramp = np.linspace(-1.0, 1.0, n)
    bare = rows - rows.mean(axis=-1, keepdims=True) - (rows @ ramp / (ramp @ ramp))[:, None] * ramp
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
