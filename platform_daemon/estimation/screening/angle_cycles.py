"""Swings of an angle record: its frequency, its passages through zero and its turning points, from the samples alone.

The angle is what is read, so nothing has to be inferred from harmonics; but the record may hold six periods only, of
a motion that loses most of its amplitude in them, slowed down to half its natural frequency, read coarsely.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import rfft

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.thresholds import THRESHOLDS

from .fundamental import SpectralPeak

LIMITS = THRESHOLDS.screening


def find_angle_frequency(samples: Array, sampling_rate_hz: float) -> SpectralPeak | None:
    """Frequency of the first swings of an angle, samples (1, n); None if nothing moves.

    Ever longer beginnings are looked at until one holds six periods: later swings are faster, and weaker.
    """
    y = samples[0]
    length = min(LIMITS.angle_first_samples, y.size)
    while True:
        cycles, significance = _strongest(y[:length])
        if length == y.size or (cycles >= LIMITS.angle_enough_periods and significance > LIMITS.angle_certain_power):
            break
        length = min(2 * length, y.size)
    return SpectralPeak(cycles * sampling_rate_hz / length, significance) if cycles > 0.0 else None


def _strongest(y: Array) -> tuple[float, float]:
    """(cycles in the segment, power over the median power) of the strongest line; (0, 0) if there is none."""
    window = np.hanning(y.size)
    spectrum = rfft((y - np.sum(window * y) / np.sum(window)) * window, LIMITS.angle_padding * y.size)
    power = spectrum.real**2 + spectrum.imag**2
    lowest = math.ceil(LIMITS.angle_fewest_cycles * LIMITS.angle_padding)
    if power.size <= lowest + 1:
        return 0.0, 0.0
    peak = lowest + int(np.argmax(power[lowest:]))
    if power[peak] <= 0.0:
        return 0.0, 0.0
    floor = float(np.median(power[lowest:]))
    return peak / LIMITS.angle_padding, float(power[peak]) / floor if floor > 0.0 else math.inf


@dataclass(frozen=True, kw_only=True)
class HalfCycles:
    """Half cycles that lie between two passages through zero.

    Attributes:
        passages_s: (k + 1,) times of the passages.
        turning_rad: (k,) signed angle of the turning point between two of them.
        turning_s: (k,) its time.
        zero_rad: where zero is on the angle's scale.
    """

    passages_s: Array
    turning_rad: Array
    turning_s: Array
    zero_rad: float


def find_half_cycles(y: Array, *, first: int, dt_s: float, frequency_hz: float) -> HalfCycles | None:
    """Half cycles of the angle y (n,), whose first sample has number `first`; None if there are fewer than two.

    Samples are averaged to blocks, 40 per period, so that neither noise nor coarse steps make passages of their own.
    """
    block = max(1, int(1.0 / (frequency_hz * dt_s * LIMITS.angle_points_per_period)))
    blocks = y.size // block
    data: Array = y[: blocks * block].reshape(blocks, block) @ np.full(block, 1.0 / block)
    time: Array = np.asarray((first + (np.arange(blocks) + 0.5) * block - 0.5) * dt_s)
    points = 1.0 / (frequency_hz * block * dt_s)
    zero = _middle(data, int(2.0 * points))
    found: HalfCycles | None = None
    for _ in range(LIMITS.angle_zero_rounds):
        found = _half_cycles(data - zero, time, points)
        if found is None:
            return None
        zero += _centre(found.turning_rad)
    return replace(found, zero_rad=zero) if found is not None else None


def _middle(data: Array, points: int) -> float:
    """Middle between the extremes of the first two periods."""
    early = data[: max(points, LIMITS.angle_first_points)]
    return 0.5 * float(early.max() + early.min())


def _centre(turning: Array) -> float:
    """Zero of the scale from turning points of a decaying motion: each lies between its neighbours' mean and itself."""
    if turning.size < 3:
        return 0.0
    return float(np.median(0.25 * (turning[:-2] + 2.0 * turning[1:-1] + turning[2:])))


def _half_cycles(x: Array, time: Array, points: float) -> HalfCycles | None:
    """Passages and turning points of x (blocks,) around 0, as long as the swings stand out of the noise.

    points: blocks per period.
    """
    noise = 1.5 * float(np.median(np.abs(np.diff(x, 3)))) / math.sqrt(20.0)
    passages, turning, when = [], [], []
    level = LIMITS.angle_swing_share * float(np.max(np.abs(x[: max(LIMITS.angle_first_points, int(points))])))
    side, since = 0, 0
    for k, value in enumerate(x):
        new = 1 if value > level else -1 if value < -level else 0
        if new == 0 or new == side:
            continue
        if side != 0:
            # The passage lies in the last change of sign before the level was reached.
            j = since + int(np.flatnonzero(np.sign(x[since:k]) * side > 0)[-1])
            passages.append(time[j] + (time[j + 1] - time[j]) * x[j] / (x[j] - x[j + 1]))
            if len(passages) > 1:
                at, value_there = _extreme(x[since : j + 1] * side, max(1, int(LIMITS.angle_extremum_share * points)))
                turning.append(side * value_there)
                when.append(time[since] + at * (time[1] - time[0]))
                level = max(LIMITS.angle_swing_share * value_there, LIMITS.angle_swing_over_noise * noise)
        side, since = new, k
    if len(turning) < 2:
        return None
    return HalfCycles(
        passages_s=np.array(passages), turning_rad=np.array(turning), turning_s=np.array(when), zero_rad=0.0
    )


def _extreme(x: Array, reach: int) -> tuple[float, float]:
    """(place, value) of the maximum, by a parabola through `reach` points on either side of it."""
    peak = int(np.argmax(x))
    near = np.arange(max(0, peak - reach), min(x.size, peak + reach + 1))
    if near.size < 3:
        return float(peak), float(x[peak])
    a, b, c = np.polyfit(near - peak, x[near], 2)
    if a >= 0.0 or abs(b / (2.0 * a)) > reach:
        return float(peak), float(x[peak])
    return peak - b / (2.0 * a), float(c - b * b / (4.0 * a))
