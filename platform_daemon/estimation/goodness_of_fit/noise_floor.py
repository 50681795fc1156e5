"""The noise of an angle as its residual shows it: the level above the motion's harmonics, and what is below.

The noise of an angle record cannot be measured beside the few harmonics of few periods. What a model leaves over
is at the low harmonics; the noise reaches further up. So the upper part of the residual's spectrum shows the
noise, and the lower part shows whether the residual is nothing else. Both bands are wide and lie side by side: what
colours noise smoothly (a sensor that is slow, coarse steps) makes them hardly differ; a misfit makes them differ by
orders of magnitude.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.fft import rfft

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.goodness_of_fit
POINTS_PER_PERIOD = LIMITS.floor_points_per_period

_SHARED = 35.0 / 18.0  # variance of a mean over bins of a Hann window, over that of independent ones
_MEDIAN = 1.0 / math.log(2.0)  # relative standard deviation of a median of powers, over that of their mean


@dataclass(frozen=True, kw_only=True)
class NoiseFloor:
    """The noise that a residual shows, and the misfit above it.

    Attributes:
        density: power density above the harmonics, two-sided, in the record's unit squared per Hz.
        surely_above: a density this many times another one is larger beyond doubt.
        excess: density at the low harmonics over that density.
        sure: the excess is beyond what chance and a smooth colour can do.
    """

    density: float
    surely_above: float
    excess: float
    sure: bool

    def sd(self, rate_hz: float) -> float:
        """Standard deviation of white noise with that density, sampled or averaged at this rate."""
        return math.sqrt(self.density * rate_hz)

    def widening(self, sd: float, rate_hz: float) -> float:
        """So many times the variances that noise of this standard deviation explains, at this sampling rate.

        A misfit counts as if it were noise. It is none, and can move the parameters further still.
        Without one, what noise does whose density is highest near the motion; 1 where that is not beyond doubt.
        """
        above = self.density * rate_hz / sd**2
        if self.sure:
            return max(1.0, above * self.excess)
        return above if above > self.surely_above else 1.0


def noise_floor_of(residual: Array, rate_hz: float, frequency_hz: float) -> NoiseFloor | None:
    """The floor of a residual (n,) of so many points per second; None if there are too few bins to see one."""
    n = residual.size
    taper = np.hanning(n)
    power = np.abs(rfft((residual - residual.mean()) * taper)) ** 2 / float(taper @ taper)
    harmonic = np.arange(power.size) * rate_hz / (n * frequency_hz)
    low = power[(harmonic > 0.0) & (harmonic < LIMITS.floor_split_harmonics)]
    # Lines of misfit at high harmonics are in less than half of these bins.
    high = power[(harmonic >= LIMITS.floor_split_harmonics) & (harmonic < LIMITS.floor_highest_harmonics)]
    if min(low.size, high.size) < LIMITS.floor_bins:
        return None
    level = max(float(np.median(high)) * _MEDIAN, 1e-300)
    excess = float(low.mean()) / level
    chance = _MEDIAN**2 / high.size
    return NoiseFloor(
        density=level / rate_hz,
        surely_above=_surely(chance),
        excess=excess,
        sure=excess > _surely(chance, 1.0 / low.size),
    )


def _surely(*variances: float) -> float:
    """A ratio of densities beyond chance and smooth colour; variances: of their logarithms, were bins independent."""
    return max(LIMITS.floor_colour, math.exp(LIMITS.floor_sigma * math.sqrt(_SHARED * sum(variances))))
