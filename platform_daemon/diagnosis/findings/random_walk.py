"""Random walks in linear equations: their significance, variance and course.

A random walk has steps u (k,) of variance sigma^2 each. A record gives the information A (k, k) and the gradient g (k,)
of these steps; with noise alone g is normal with covariance f A, f the noise factor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import norm

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

_LIMITS = THRESHOLDS.findings


@dataclass(frozen=True)
class Walk:
    """A walk as the data have it.

    Attributes:
        steps, covariance: (k,) and (k, k) given the data, at the likeliest variance.
        evidence: rise of the log likelihood over that of no walk; 0 if the likeliest variance is 0.
    """

    steps: Array
    covariance: Array
    evidence: float


def log_chance_of_walk(information: Array, gradient: Array, noise_factor: float, values: float) -> float:
    """Logarithm of the chance of such a gradient if nothing walks, by two tests, corrected for their number.

    The score test of the variance: the sum of the squares of the gradient is by chance one of squares of normal numbers
    with the eigenvalues of the information as weights. It favours the course that is best determined; the other
    test, the gain of a free course, weights all equally. values: independent ones that the noise factor is known from.
    """
    weights, vectors = np.linalg.eigh(information)
    largest = float(weights[-1])
    if not (largest > 0.0 and values > 0.0):
        return 0.0
    visible = weights > _LIMITS.walk_share * largest
    squares = (vectors[:, visible].T @ gradient) ** 2 / noise_factor
    score = log_tail(weights[visible] / largest, float(squares.sum()) / largest, values)
    course = log_tail(np.ones(int(visible.sum())), float(np.sum(squares / weights[visible])), values)
    return min(0.0, min(score, course) + math.log(2.0))


def log_tail(weights: Array, ratio: float, values: float) -> float:
    """Logarithm of the chance that sum of weights (k,), the largest of which is 1, times chi^2_1 exceeds the ratio
    times chi^2 of `values` degrees of freedom over their number.

    By the saddle point of the cumulants (Kuonen, Biometrika 86 (1999) 929): within some ten per cent, however small.
    """
    mean = float(weights.sum())
    if ratio <= 0.0:
        return 0.0
    if abs(ratio / mean - 1.0) < _LIMITS.near_mean:
        ratio = mean * (1.0 + _LIMITS.near_mean)
    down = ratio / values

    def slope(t: float) -> float:
        return float(np.sum(weights / (1.0 - 2.0 * t * weights))) - ratio / (1.0 + 2.0 * t * down)

    high = 0.5 - 0.25 / max(ratio, 1.0)
    while slope(high) < 0.0:
        high = 0.5 - 0.5 * (0.5 - high)
    t = float(brentq(slope, -0.5 / down * (1.0 - 1e-9), high, xtol=1e-300, rtol=1e-14))
    left, right = 1.0 - 2.0 * t * weights, 1.0 + 2.0 * t * down
    cumulant = -0.5 * float(np.sum(np.log(left))) - 0.5 * values * math.log(right)
    bend = 2.0 * float(np.sum((weights / left) ** 2)) + 2.0 * values * (down / right) ** 2
    w = math.copysign(math.sqrt(max(-2.0 * cumulant, 1e-300)), t)
    return min(0.0, float(norm.logsf(w + math.log(t * math.sqrt(bend) / w) / w)))


def walk(information: Array, gradient: Array, noise_factor: float) -> Walk:
    """The likeliest walk, its variance by the marginal likelihood."""
    values, vectors = np.linalg.eigh(information)
    values = np.maximum(values, 0.0) / noise_factor
    along = vectors.T @ gradient / noise_factor

    def loss(log_variance: float) -> float:
        variance = math.exp(log_variance)
        taken = 1.0 + variance * values
        return 0.5 * float(np.sum(np.log(taken) - variance * along**2 / taken))

    middle = -math.log(max(float(values[-1]), 1e-300))
    reach = _LIMITS.variance_decades * math.log(10.0)
    grid = np.linspace(middle - reach, middle + 2.0 * reach, _LIMITS.variance_points)
    best = int(np.argmin([loss(x) for x in grid]))
    ends = grid[max(best - 1, 0)], grid[min(best + 1, grid.size - 1)]
    found = minimize_scalar(loss, bounds=ends, method="bounded")
    spread = vectors / (values + math.exp(-float(found.x)))
    return Walk(spread @ along, spread @ vectors.T, max(0.0, -float(found.fun)))
