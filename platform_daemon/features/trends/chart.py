"""A control chart of one quantity: an EWMA of prediction errors, and since when something has changed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .ewma import ewma_width, steady_std
from .prediction import Array, Kinds, Learned, course_of, later_scores, temperature_terms

WEIGHT = 0.1
"""Of the newest point in the EWMA: small and slow changes are what a specimen does."""
_CORRELATED_FROM, _CORRELATED_OF = 20, 200  # scores from which the correlation of neighbours is taken
_CHANCE = 1.6  # a correlation of fewer standard deviations may be chance
_MOST_CORRELATED = 0.9


@dataclass(frozen=True)
class ChartAlarm:
    """since: index of the first point after the change, as likely as it can be said; noticed: of the point at which the
    chart left its limits; stands: the chart is still outside at the last point; shift: mean score since then, standard
    deviations of a point."""

    since: int
    noticed: int
    stands: bool
    shift: float


@dataclass(frozen=True, eq=False)
class Chart:
    """score, ewma, limit: (n,), NaN while the chart learns; learned: what it holds the last points against; std: (n,),
    standard deviation of each point by that; terms: X (n, k)."""

    score: Array
    ewma: Array
    limit: Array
    learned: Learned
    std: Array
    terms: Array
    alarm: ChartAlarm | None


def chart(y: Array, temperature_c: Array, run_length: float, shots: Kinds | None = None) -> Chart:
    """The chart of y (n,), NaN: missing, at temperatures (n,), degrees Celsius, NaN: not measured.

    shots: (n,), that each is the mean of, None: of one.  How much less many scatter than few is learned, not taken to
    be known: what differs from recording to recording does not become less with shots.  run_length: points to a false
    alarm, on average.  After an alarm nothing more is learned, and the points are held against what was learned before
    the change.
    """
    terms = temperature_terms(temperature_c)
    kinds = _kinds(np.ones(len(y), int) if shots is None else shots)
    course, scores = course_of(terms, y, kinds)
    limit = ewma_width(WEIGHT, run_length) * steady_std(WEIGHT) * _widened(scores)
    ewma = _ewma(scores)
    outside = np.flatnonzero(np.abs(ewma) > limit)
    if not outside.size:
        learned = course.before(len(y))
        return Chart(scores, ewma, limit, learned, learned.stds[kinds], terms, None)
    noticed = int(outside[0])
    since = _change(scores, noticed)
    learned = course.before(since)
    scores = np.concatenate([scores[:since], later_scores(learned, terms[since:], y[since:], kinds[since:])])
    ewma = _ewma(scores)
    shown = np.flatnonzero(np.isfinite(scores))
    stands = bool(abs(ewma[shown[-1]]) > limit[shown[-1]])
    shift = float(np.nanmean(scores[since : noticed + 1]))
    return Chart(scores, ewma, limit, learned, learned.stds[kinds], terms, ChartAlarm(since, noticed, stands, shift))


def _ewma(scores: Array) -> Array:
    """The moving average after each score, (n,); NaN where the score is NaN, which leaves the average unchanged."""
    known = np.isfinite(scores)
    z, averages = 0.0, []
    for score in scores[known].tolist():
        z = (1.0 - WEIGHT) * z + WEIGHT * score
        averages.append(z)
    found = np.full(len(scores), np.nan)
    found[known] = averages
    return found


def _change(scores: Array, noticed: int) -> int:
    """Index of the point from which on a shift of the mean is most likely."""
    places = np.flatnonzero(np.isfinite(scores[: noticed + 1]))
    sums = np.cumsum(scores[places][::-1])[::-1]
    return int(places[np.argmax(sums**2 / np.arange(len(places), 0, -1))])


def _kinds(shots: Kinds) -> Kinds:
    """1, 2 to 3, 4 to 7, ... shots are one kind each, numbered from 0."""
    found: Kinds = np.unique(np.frexp(shots.astype(float))[1], return_inverse=True)[1]
    return found


def _widened(scores: Array) -> NDArray[np.float64]:
    """Factor by which correlated neighbours widen the EWMA, from the first scores; 1 where that may be chance."""
    places = np.flatnonzero(np.isfinite(scores))
    known = scores[places]
    alike, newest = np.zeros(len(scores)), 0.0
    for count in range(_CORRELATED_FROM, min(len(known), _CORRELATED_OF) + 1, 4):
        found = _correlation(known[:count])
        newest = min(found, _MOST_CORRELATED) if found > _CHANCE / np.sqrt(count) else 0.0
        alike[places[count - 1] :] = newest
    return np.sqrt((1.0 + (1.0 - WEIGHT) * alike) / (1.0 - (1.0 - WEIGHT) * alike))


def _correlation(scores: Array) -> float:
    """Correlation of neighbouring scores after removal of the most likely step, which is not correlation."""
    sums, places = np.cumsum(scores), np.arange(1, len(scores))
    gain = sums[:-1] ** 2 / places + (sums[-1] - sums[:-1]) ** 2 / (len(scores) - places)
    at = int(np.argmax(gain)) + 1
    rest = np.concatenate([part - part.mean() for part in (scores[:at], scores[at:])])
    return float(rest[1:] @ rest[:-1] / max(float(rest @ rest), 1e-12))
