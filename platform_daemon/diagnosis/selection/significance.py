"""How surprising a gain is, after correction for everything that was tried, on a logarithmic scale."""

from __future__ import annotations

import math

from scipy.special import chdtrc

LEVEL = math.log(1e-3)  # an effect is accepted below
_SMALLEST = 1e-300


def log_chance(gain: float, parameters: int, trials: float = 1.0) -> float:
    """Logarithm of the chance that noise gains as much anywhere in so many trials, at most 0."""
    if parameters == 0 or not gain > 0.0:
        return 0.0
    share = float(chdtrc(parameters, gain))
    if share > _SMALLEST:
        found = math.log(share)
    else:  # far out: the leading term
        half = 0.5 * gain
        found = -half + (0.5 * parameters - 1.0) * math.log(half) - math.lgamma(0.5 * parameters)
    return min(0.0, found + math.log(max(trials, 1.0)))


def chance(log_p: float) -> float:
    """The p-value; 0 below the smallest number."""
    return math.exp(max(log_p, -745.0)) if log_p > -745.0 else 0.0
