"""What the points before say of the next one: errors of one-step predictions, each over its own uncertainty.

y = b_0 + b_1 T + b_2 T^2 + noise, fitted to the points before. The errors w_i = (y_i - x_i b) / sqrt(1 + h_i), h_i =
x_i (X^T X)^-1 x_i^T, are independent and of one variance as long as nothing changes (recursive residuals: Brown,
Durbin, Evans, J. R. Stat. Soc. B 37 (1975) 149), and over the standard deviation of those before they are t
distributed, so that a chart needs no baseline of known mean, variance or temperature coefficient (self-starting charts:
Hawkins, The Statistician 36 (1987) 299).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from operator import mul

import numpy as np
import scipy  # see ewma.py
from numpy.typing import NDArray

Array = NDArray[np.float64]
Kinds = NDArray[np.int_]
LEARNED_FROM = 8
"""Prediction errors of a kind before its first score."""
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
    """What a stretch of points has taught: normal equations (k, k), (k,); of each kind of points the sum of the squared
    errors of its predictions, (c,), and their number, (c,)."""

    normal: Array
    right: Array
    squares: Array
    errors: NDArray[np.int_]

    @property
    def coefficients(self) -> Array:
        """b (k,)."""
        return np.asarray(np.linalg.solve(self.normal, self.right), np.float64)

    @property
    def count(self) -> int:
        """Predictions whose errors are known."""
        return int(self.errors.sum())

    @property
    def std(self) -> float:
        """Standard deviation of y about the model, over all kinds; NaN before it is known."""
        return float(np.sqrt(self.squares.sum() / self.count)) if self.count >= LEARNED_FROM else float("nan")

    @property
    def stds(self) -> Array:
        """That of each kind, (c,), none below that of all: what scattered points have taught is not known better than
        they are."""
        known = self.errors >= LEARNED_FROM
        own = np.sqrt(self.squares / np.maximum(self.errors, 1))
        return np.where(known, np.maximum(own, self.std), np.nan)


@dataclass(frozen=True, eq=False)
class Course:
    """What was known before each of n points, and after the last.

    used: (n,), points that have a value and a temperature; normals (m + 1, k, k), rights (m + 1, k), squares (m + 1,
    c), errors (m + 1, c): as in Learned, before each of those m and after the last.
    """

    used: NDArray[np.bool_]
    normals: Array
    rights: Array
    squares: Array
    errors: NDArray[np.int_]

    def before(self, i: int) -> Learned:
        """What the points before point i have taught; i = n: all of them."""
        k = int(np.count_nonzero(self.used[:i]))
        return Learned(self.normals[k], self.rights[k], self.squares[k], self.errors[k])


@dataclass(frozen=True, eq=False)
class _Rows:
    """Of m points: x (m, k), x (X^T X)^-1 (m, k) and h (m,) by those before, kind (m,)."""

    x: Array
    gains: Array
    leverage: Array
    kinds: Kinds


def course_of(x: Array, y: Array, kinds: Kinds) -> tuple[Course, Array]:
    """What was known before each point, and the score of each, (n,), NaN for one that has none.

    kinds: (n,), from 0: each has a standard deviation of its own.
    """
    used = np.isfinite(y) & np.isfinite(x).all(axis=1)
    rows = x[used]
    size = x.shape[1]
    # Sums of rows alone, for all points at once: a trend of years is judged after each of its recordings.
    seen = np.cumsum(rows[:, :, None] * rows[:, None, :], axis=0)
    normals = np.concatenate([np.zeros((1, size, size)), seen]) + np.eye(size) * _UNSEEN
    gains = np.asarray(np.linalg.solve(normals[:-1], rows[:, :, None])[:, :, 0], np.float64)
    leverage: Array = np.einsum("ij,ij->i", rows, gains)
    taught, squares, errors, scores = _taught(
        _Rows(rows, gains, leverage, kinds[used]), y[used], int(kinds.max(initial=0))
    )
    rights = np.concatenate([np.zeros((1, size)), np.cumsum(rows * taught[:, None], axis=0)])
    found = np.full(len(y), np.nan)
    found[used] = normal_scores(scores, np.take_along_axis(errors[:-1], kinds[used][:, None], 1)[:, 0])
    return Course(used, normals, rights, squares, errors), found


def _taught(rows: _Rows, y: Array, highest: int) -> tuple[Array, Array, NDArray[np.int_], Array]:
    """Values that are learned from, a wild one as far as MOST_SCORE standard deviations; sums of squared errors and
    their number before each point and after the last; errors over the standard deviation before each."""
    most = _most_of(len(y))
    widths, seen = np.sqrt(1.0 + rows.leverage).tolist(), (rows.leverage < _HIGHEST_LEVERAGE).tolist()
    right = [0.0] * rows.x.shape[1]
    taught, scores, kept_errors = y.tolist(), [math.nan] * len(y), [0.0] * len(y)
    squares, errors = [0.0] * (highest + 1), [0] * (highest + 1)
    all_squares, all_errors = 0.0, 0
    # Plain numbers, and no lists, at which the collector of garbage would look: years of a specimen are 10^5 turns.
    columns = (zip(*each.T.tolist(), strict=True) for each in (rows.x, rows.gains))
    for i, (row, gain, kind) in enumerate(zip(*columns, rows.kinds.tolist(), strict=True)):
        if seen[i]:
            error = (taught[i] - sum(map(mul, gain, right))) / widths[i]
            known = errors[kind]
            if known >= LEARNED_FROM:  # the standard deviation is that of `Learned.stds`
                std = math.sqrt(max(squares[kind] / known, all_squares / all_errors))
                if std > 0.0:
                    scores[i] = error / std
                    if abs(scores[i]) > most[known]:
                        kept = math.copysign(most[known] * std, error)
                        taught[i] -= (error - kept) * widths[i]
                        error = kept
            kept_errors[i] = error
            squares[kind] += error**2
            errors[kind] += 1
            all_squares += error**2
            all_errors += 1
        value = taught[i]
        for j, each in enumerate(row):
            right[j] += each * value
    of_kind = np.eye(highest + 1)[rows.kinds]
    return (
        np.array(taught),
        _before(of_kind * np.square(kept_errors)[:, None]),
        _before(of_kind * np.array(seen)[:, None]).astype(int),
        np.array(scores),
    )


def _before(parts: Array) -> Array:
    """Sums of the rows (m, c) before each, and of all of them, (m + 1, c)."""
    return np.concatenate([np.zeros((1, parts.shape[1])), np.cumsum(parts, axis=0)])


def _most_of(points: int) -> list[float]:
    """MOST_SCORE of a standard deviation that is known from 0, 1, ... `points` errors."""
    return _most_to(1 << points.bit_length())


@lru_cache(32)
def _most_to(errors: int) -> list[float]:
    found = -scipy.special.stdtrit(np.arange(errors + 1), scipy.special.ndtr(-MOST_SCORE))
    return [float(each) for each in np.asarray(found, np.float64)]


def later_scores(learned: Learned, x: Array, y: Array, kinds: Kinds) -> Array:
    """Scores of points that are not learned from."""
    leverage = np.sum(x * np.linalg.solve(learned.normal, x.T).T, axis=1)
    with np.errstate(invalid="ignore"):
        errors = (y - x @ learned.coefficients) / np.sqrt(1.0 + leverage) / learned.stds[kinds]
    errors[~(leverage < _HIGHEST_LEVERAGE)] = np.nan
    return normal_scores(errors, learned.errors[kinds])


def normal_scores(errors: Array, freedom: NDArray[np.int_]) -> Array:
    """Errors of a t distribution as those of a normal one, at most MOST_SCORE."""
    known = np.isfinite(errors)
    scores = np.full(len(errors), np.nan)
    # By the tail, which keeps its digits.  These are scipy.stats.t and norm, which take as long to load as a trend.
    tail = scipy.special.stdtr(freedom[known], -np.abs(errors[known]))
    scores[known] = -np.sign(errors[known]) * scipy.special.ndtri(np.maximum(tail, 1e-12))
    return np.clip(scores, -MOST_SCORE, MOST_SCORE)
