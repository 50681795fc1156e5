"""A control chart of one quantity: an EWMA of prediction errors, and since when something has changed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .ewma import ewma_width, steady_std
from .prediction import Array, Learned, course_of, later_scores, temperature_terms

WEIGHT = 0.1
"""Of the newest point in the EWMA: small and slow changes are what a specimen does."""
_CORRELATED_FROM, _CORRELATED_OF = 30, 100  # scores from which the correlation of neighbours is taken
_MOST_CORRELATED = 0.9


@dataclass(frozen=True)
class ChartAlarm:
    """since: index of the first point after the change, as likely as it can be said; noticed: of the point at which the
    chart left its limits; stands: at the last point it is still outside; shift: mean score since then, standard
    deviations of a point."""

    since: int
    noticed: int
    stands: bool
    shift: float


@dataclass(frozen=True, eq=False)
class Chart:
    """score, ewma, limit: (n,), NaN while the chart learns; learned: what it holds the last points against; terms: X
    (n, k)."""

    score: Array
    ewma: Array
    limit: Array
    learned: Learned
    terms: Array
    alarm: ChartAlarm | None


def chart(y: Array, temperature_c: Array, run_length: float) -> Chart:
    """The chart of y (n,), NaN: missing, at temperatures (n,), degrees Celsius, NaN: not measured.

    run_length: points to a false alarm, on average. After an alarm nothing more is learned, and the points are held
    against what was learned before the change.
    """
    terms = temperature_terms(temperature_c)
    known, scores = course_of(terms, y)
    limit = ewma_width(WEIGHT, run_length) * steady_std(WEIGHT) * _widened(scores)
    ewma = _ewma(scores)
    outside = np.flatnonzero(np.abs(ewma) > limit)
    if not outside.size:
        return Chart(scores, ewma, limit, known[-1], terms, None)
    noticed = int(outside[0])
    since = _change(scores, noticed)
    learned = known[since]
    scores = np.concatenate([scores[:since], later_scores(learned, terms[since:], y[since:])])
    ewma = _ewma(scores)
    shown = np.flatnonzero(np.isfinite(scores))
    stands = bool(abs(ewma[shown[-1]]) > limit[shown[-1]])
    shift = float(np.nanmean(scores[since : noticed + 1]))
    return Chart(scores, ewma, limit, learned, terms, ChartAlarm(since, noticed, stands, shift))


def _ewma(scores: Array) -> Array:
    z, found = 0.0, np.full(len(scores), np.nan)
    for i, score in enumerate(scores):
        if np.isfinite(score):
            z = (1.0 - WEIGHT) * z + WEIGHT * score
            found[i] = z
    return found


def _change(scores: Array, noticed: int) -> int:
    """The point from which on a shift of the mean is most likely."""
    places = np.flatnonzero(np.isfinite(scores[: noticed + 1]))
    sums = np.cumsum(scores[places][::-1])[::-1]
    return int(places[np.argmax(sums**2 / np.arange(len(places), 0, -1))])


def _widened(scores: Array) -> NDArray[np.float64]:
    """By how much neighbours that are alike widen the EWMA, from the first scores: 1 where that may be chance."""
    filled = np.where(np.isfinite(scores), scores, 0.0)
    count = np.cumsum(np.isfinite(scores))
    products = np.cumsum(np.append(0.0, filled[1:] * filled[:-1]))
    squares = np.maximum(np.cumsum(filled**2), 1e-12)
    alike = products / squares
    learned = (count >= _CORRELATED_FROM) & (alike > 2.0 / np.sqrt(np.maximum(count, 1)))
    alike = np.where(learned, np.minimum(alike, _MOST_CORRELATED), 0.0)
    last = int(np.searchsorted(count, _CORRELATED_OF))
    alike[last:] = alike[last : last + 1]
    return np.sqrt((1.0 + (1.0 - WEIGHT) * alike) / (1.0 - (1.0 - WEIGHT) * alike))
