"""What the points before say of the next one: errors of one-step predictions, each over its own uncertainty.

y = b_0 + b_1 T + b_2 T^2 + noise, fitted to the points before. The errors w_i = (y_i - x_i b) / sqrt(1 + h_i), h_i =
x_i (X^T X)^-1 x_i^T, are independent and of one variance as long as nothing changes (recursive residuals: Brown,
Durbin, Evans, J. R. Stat. Soc. B 37 (1975) 149), and over the standard deviation of those before they are t
distributed, so that a chart needs no baseline of known mean, variance or temperature coefficient (self-starting charts:
Hawkins, The Statistician 36 (1987) 299).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy  # see ewma.py
from numpy.typing import NDArray

Array = NDArray[np.float64]
LEARNED_FROM = 8
"""Prediction errors before the first score."""
MOST_SCORE = 4.0
"""What lies further out counts as this: one wild point is no change."""
_HIGHEST_LEVERAGE = 4.0  # a prediction further outside of what was seen says nothing
_UNSEEN = 1e-9  # of X^T X where nothing was seen: a direction without points has no say
_SCALE_K = 5.0


def temperature_terms(temperature_c: Array) -> Array:
    """X (n, 3), or (n, 1) if no temperature is known; NaN where it is not."""
    known = temperature_c[np.isfinite(temperature_c)]
    ones = np.ones_like(temperature_c)
    if not known.size:
        return ones[:, None]
    scaled = (temperature_c - known[0]) / _SCALE_K
    return np.stack([ones, scaled, scaled**2], axis=1)


@dataclass(frozen=True, eq=False)
class Learned:
    """What a stretch of points has taught: normal equations (k, k), (k,), sum of the squared errors of `errors`
    predictions."""

    normal: Array
    right: Array
    squares: float
    errors: int

    @property
    def coefficients(self) -> Array:
        """b (k,)."""
        return np.asarray(np.linalg.solve(self.normal, self.right), np.float64)

    @property
    def std(self) -> float:
        """Standard deviation of y about the model; NaN before it is known."""
        return float(np.sqrt(self.squares / self.errors)) if self.errors >= LEARNED_FROM else float("nan")

    def leverage(self, x: Array) -> float:
        """h of a row x."""
        return float(x @ np.linalg.solve(self.normal, x))

    def error(self, x: Array, y: float) -> float:
        """w of a point; NaN if it is outside of what was seen."""
        h = self.leverage(x)
        return float((y - x @ self.coefficients) / np.sqrt(1.0 + h)) if h < _HIGHEST_LEVERAGE else float("nan")

    def with_point(self, x: Array, y: float) -> Learned:
        """One more point; a wild one counts as far as MOST_SCORE standard deviations."""
        error, squares, errors = self.error(x, y), self.squares, self.errors
        if np.isfinite(error):
            most = _most(errors) * self.std if self.std > 0 else np.inf
            if abs(error) > most:
                y -= float(np.sign(error) * (abs(error) - most) * np.sqrt(1.0 + self.leverage(x)))
                error = most
            squares, errors = squares + error**2, errors + 1
        return Learned(self.normal + np.outer(x, x), self.right + x * y, squares, errors)


@lru_cache(None)
def _most(errors: int) -> float:
    """MOST_SCORE of a standard deviation that is known from so many errors."""
    return float(scipy.stats.t.isf(scipy.stats.norm.sf(MOST_SCORE), errors))


def nothing_learned(terms: int) -> Learned:
    """Before the first point."""
    return Learned(np.eye(terms) * _UNSEEN, np.zeros(terms), 0.0, 0)


def course_of(x: Array, y: Array) -> tuple[list[Learned], Array]:
    """What was known before each point, (n + 1) of them, and the score of each, (n,), NaN for one that has none."""
    known, scores = [nothing_learned(x.shape[1])], np.full(len(y), np.nan)
    for i, (row, value) in enumerate(zip(x, y, strict=True)):
        before = known[-1]
        if not np.isfinite(value) or not np.isfinite(row).all():
            known.append(before)
            continue
        scores[i] = before.error(row, value) / before.std if before.std > 0 else np.nan
        known.append(before.with_point(row, value))
    return known, normal_scores(scores, np.array([each.errors for each in known[:-1]]))


def later_scores(learned: Learned, x: Array, y: Array) -> Array:
    """Scores of points that are not learned from."""
    found = [
        learned.error(row, value) / learned.std if np.isfinite(value) and np.isfinite(row).all() else np.nan
        for row, value in zip(x, y, strict=True)
    ]
    return normal_scores(np.array(found), np.full(len(y), learned.errors))


def normal_scores(errors: Array, freedom: NDArray[np.int_]) -> Array:
    """Errors of a t distribution as those of a normal one, at most MOST_SCORE."""
    known = np.isfinite(errors)
    scores = np.full(len(errors), np.nan)
    # by the tail, which keeps its digits
    tail = np.log(2.0) + scipy.stats.t.logsf(np.abs(errors[known]), freedom[known])
    scores[known] = np.sign(errors[known]) * scipy.stats.norm.isf(np.maximum(np.exp(tail) / 2.0, 1e-12))
    return np.clip(scores, -MOST_SCORE, MOST_SCORE)
