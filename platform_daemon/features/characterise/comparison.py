"""N50 against D30, shot by shot: is the mean of the differences zero?

The paper says which means differ at alpha = 0.001 (ssec:primary_results) and names neither the test nor a correction
for testing many quantities. Both fits of a shot share its samples, its noise and its start, so that the differences
are compared and not the two sets: Student's t test of their mean, two-sided, with Holm's correction
(S. Holm, Scand. J. Statist. 6, 65, 1979): the chance of calling any difference of equal means significant is at most
alpha over all quantities of a resonator.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array

from .schema import WindowComparison

_FEWEST = 2
_FEWEST_IN_A_ROW = 10  # for a correlation from shot to shot
_ROUNDING = 1e-12  # of the values: what differs by less does not differ


@dataclass(frozen=True)
class Pairs:
    """One quantity, or why it cannot be compared.

    n50, d30: of the shots that have it in both, in the order in which they were made.
    """

    quantity: str
    n50: Sequence[float] = field(default=())
    d30: Sequence[float] = field(default=())
    circular: bool = False
    reason: str | None = None

    def differences(self) -> Array:
        """N50 minus D30, (shots,); of angles on the circle the shorter way."""
        found = np.subtract(self.n50, self.d30, dtype=np.float64)
        return np.asarray(np.remainder(found + math.pi, 2.0 * math.pi) - math.pi) if self.circular else found

    def why_not(self) -> str | None:
        """Why there is no test; None: there is one."""
        if self.reason is not None:
            return self.reason
        if len(self.n50) < _FEWEST:
            return f"{len(self.n50)} of the {_FEWEST} shots that a test needs at least"
        difference = self.differences()
        if np.ptp(difference) <= _ROUNDING * np.max(np.abs([self.n50, self.d30])):
            return "the difference is the same in all shots, so that there is no scatter to compare it with"
        return None


def compare(quantities: Sequence[Pairs], alpha: float) -> tuple[WindowComparison, ...]:
    """Every quantity tested, the p values corrected for all that were."""
    rows = [_tested(pairs, alpha) for pairs in quantities]
    adjusted = iter(holm([row.p_value for row in rows if row.p_value is not None]))
    corrected = []
    for row in rows:
        if row.p_value is not None:
            p = next(adjusted)
            row = row.model_copy(update={"p_adjusted": p, "significant": p < alpha})
        corrected.append(row)
    return tuple(corrected)


def holm(p_values: Sequence[float]) -> list[float]:
    """Adjusted p values in the same order: each below alpha is significant with a family-wise error of alpha."""
    order = np.argsort(p_values, kind="stable")
    factors = len(p_values) - np.arange(len(p_values))
    stepped = np.minimum(1.0, np.maximum.accumulate(np.asarray(p_values, dtype=np.float64)[order] * factors))
    adjusted = np.empty(len(p_values))
    adjusted[order] = stepped
    return [float(p) for p in adjusted]


def _tested(pairs: Pairs, alpha: float) -> WindowComparison:
    """One row, the adjusted p value still missing."""
    reason = pairs.why_not()
    difference = pairs.differences()
    if reason is not None:
        mean = float(difference.mean()) if difference.size and pairs.reason is None else None
        return _row(pairs, mean, reason=reason)
    from scipy.stats import ttest_1samp, wilcoxon  # here: half a second to load

    found = ttest_1samp(difference, 0.0)
    interval = found.confidence_interval(1.0 - alpha)
    return _row(
        pairs,
        float(difference.mean()),
        low=float(interval.low),
        high=float(interval.high),
        p_value=float(found.pvalue),
        signed_rank_p_value=float(wilcoxon(difference).pvalue),
        lag_one_correlation=_lag_one(difference),
    )


def _row(pairs: Pairs, difference: float | None, **known: float | str | None) -> WindowComparison:
    empty = dict.fromkeys(WindowComparison.model_fields)
    named = {"quantity": pairs.quantity, "shots": len(pairs.n50), "difference": difference}
    return WindowComparison.model_validate(empty | named | known)


def _lag_one(difference: Array) -> float | None:
    """Correlation of each difference with the next one."""
    if difference.size < _FEWEST_IN_A_ROW:
        return None
    rest = difference - difference.mean()
    return float(rest[1:] @ rest[:-1] / (rest @ rest))
