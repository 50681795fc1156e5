"""Does the residual hold what a wrong loss leaves: a slow misfit of amplitude or phase, far below the noise's power?

A wrong law of loss misses the envelope by a slow bow, and the phase by what that does to the frequency. Spread over a
whole window, either is too faint for chi^2 and for the spectrum. Along the motion itself it adds up.
"""

from __future__ import annotations

import math

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.jit import fast_kernel
from platform_daemon.estimation.thresholds import THRESHOLDS

from .residual import Residual

LIMITS = THRESHOLDS.goodness_of_fit


def envelope_lack_of_fit_sigma(residual: Residual, left: float) -> float:
    """By how many standard deviations the amplitude and phase in eight stretches are off together.

    left: chi^2 that the residual has above the minimum, which a last small step would take off there.
    """
    if residual.scaled.shape[1] < LIMITS.envelope_stretch_means * LIMITS.envelope_stretches:
        return 0.0
    seen = float(_along_motion(residual.scaled, residual.model, residual.sd, LIMITS.envelope_stretches)) - left
    numbers = 2.0 * LIMITS.envelope_stretches
    return (seen - numbers) / math.sqrt(2.0 * numbers)


@fast_kernel
def _along_motion(scaled: Array, model: Array, sd: Array, stretches: int) -> float:
    """Sum over stretches of the squares, in the noise's unit, of the residual (channels, n) along motion and rate."""
    length, total = (model.shape[1] - 2) // stretches, 0.0
    for k in range(stretches):
        by_motion = by_rate = motions = rates = 1e-300
        for channel in range(model.shape[0]):
            for i in range(1 + k * length, 1 + (k + 1) * length):
                motion = model[channel, i] / sd[channel]
                rate = (model[channel, i + 1] - model[channel, i - 1]) / sd[channel]
                by_motion += scaled[channel, i] * motion
                by_rate += scaled[channel, i] * rate
                motions += motion * motion
                rates += rate * rate
        total += by_motion * by_motion / motions + by_rate * by_rate / rates
    return total
