"""Logarithms of p-values, corrected for the number of trials."""

from __future__ import annotations

import math

from scipy.special import chdtrc

from platform_daemon.diagnosis.thresholds import THRESHOLDS

_LIMITS = THRESHOLDS.selection
LEVEL = math.log(_LIMITS.level_p)
"""Natural logarithm of the probability below which an effect is accepted."""


def log_chance(gain: float, parameters: int, trials: float = 1.0) -> float:
    """Log p-value of a gain of chi^2 by `parameters` in Gaussian noise, corrected for `trials`; at most 0."""
    if parameters == 0 or not gain > 0.0:
        return 0.0
    share = float(chdtrc(parameters, gain))
    if share > _LIMITS.smallest_chance:
        found = math.log(share)
    else:  # far out: the leading term
        half = 0.5 * gain
        found = -half + (0.5 * parameters - 1.0) * math.log(half) - math.lgamma(0.5 * parameters)
    return min(0.0, found + math.log(max(trials, 1.0)))


def chance(log_p: float) -> float:
    """The p-value; 0 below the smallest number."""
    return math.exp(log_p) if log_p > _LIMITS.smallest_log_p else 0.0
