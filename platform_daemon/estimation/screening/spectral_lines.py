"""What all searches for lines in a spectrum share: the spectrum, the level beside a line, its place, whose it may be.

A line is detected by one statistic, the power of a bin over the level of the noise there. In noise it is exponentially
distributed, the sum over k independent spectra (channels, shots) like a gamma variable with k degrees: a bin exceeds
25 by a chance of exp(-25), 1e-11. The threshold is chosen by each search.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.fft import rfft

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.orbit import frequency_ratio
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.screening
MAINS_HZ = LIMITS.mains_hz


def periodogram(samples: Array, window: Array, size: int | None = None) -> Array:
    """Power of windowed samples (channels, n), (channels, bins): white noise has its variance in every bin on average.

    size: of the transform, at least n.
    """
    transform = rfft(samples * window, size, axis=1)
    return np.asarray((transform.real**2 + transform.imag**2) / float(window @ window))


def median_level(power: Array, edges: Sequence[int] | np.ndarray) -> Array:
    """Medians of power (channels, bins) in the bands between the edges, drawn through their middles; above 0."""
    middles = [0.5 * (a + b) for a, b in pairwise(edges)]
    medians = np.stack([np.median(power[:, a:b], axis=1) for a, b in pairwise(edges)], axis=1)
    rows = [np.interp(np.arange(power.shape[1]), middles, row) for row in medians]
    return np.maximum(np.stack(rows), 1e-300)


def peak_shift(power: Array, k: int) -> float:
    """How far the maximum near bin k of power (bins,) lies from it, in bins: a parabola through three logarithms."""
    if not 0 < k < power.size - 1 or min(power[k - 1], power[k + 1]) <= 0.0:
        return 0.0
    left, middle, right = np.log(power[k - 1 : k + 2])
    curvature = left - 2.0 * middle + right
    return float(0.5 * (left - right) / curvature) if curvature < 0.0 else 0.0


def is_mains(
    frequency_hz: float, *, relative: float, missed_hz: float = 0.0, mains_hz: Sequence[float] = MAINS_HZ
) -> bool:
    """Near a multiple of a mains frequency, which may be off by a share `relative`.

    missed_hz: error that the frequency may have.
    """
    allowed = relative * frequency_hz + missed_hz
    return any(abs(frequency_hz - m * max(1.0, round(frequency_hz / m))) < allowed for m in mains_hz)


@dataclass(frozen=True, kw_only=True)
class Zones:
    """Frequencies that belong to the signal: k (low .. high) give or take the margin, all in Hz."""

    low_hz: float
    high_hz: float
    margin_hz: float

    @classmethod
    def of_sweep(cls, w: float, amplitude_rad: float, *, relative: float, margin_hz: float) -> Zones:
        """Of a motion with natural frequency w in rad/s that decays: slower than that the wider it swings."""
        natural_hz = w / (2.0 * np.pi)
        slowest_hz = natural_hz * frequency_ratio(min(abs(amplitude_rad), LIMITS.widest_swing_rad))
        return cls(low_hz=slowest_hz * (1.0 - relative), high_hz=natural_hz * (1.0 + relative), margin_hz=margin_hz)

    @property
    def width_hz(self) -> float:
        """Of the sweep of the fundamental; above 0."""
        return max(self.high_hz - self.low_hz, 1e-300)

    @property
    def overlap_from(self) -> float:
        """Order of the first harmonic whose sweep reaches that of the next one."""
        return self.low_hz / self.width_hz

    def holds(self, frequency_hz: Array | float) -> np.ndarray:
        """True where a harmonic may be."""
        k = np.maximum(np.round(frequency_hz / (0.5 * (self.low_hz + self.high_hz))), 1.0)
        inside = np.zeros(np.shape(frequency_hz), dtype=bool)
        for n in (k - 1.0, k, k + 1.0):
            above, below = n * self.low_hz - self.margin_hz, n * self.high_hz + self.margin_hz
            inside |= (n > 0.0) & (frequency_hz > above) & (frequency_hz < below)
        return inside
