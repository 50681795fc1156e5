"""Propagation of distributions by a Monte Carlo method, and the check of the law of propagation by it (JCGM 101:2008).

Clause 7: draws of all inputs through the model; 7.9: blocks of draws until the results are stable; 8: the law of
propagation holds where its interval and that of the draws agree to the numerical tolerance of clause 7.9.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drivers.errors import InputError

from .budget import Budget, checked_coverage
from .inputs import SPREAD, Array, Correlations, InputQuantity, correlation_matrix, groups
from .propagation import Model, results_of

BLOCK = 10_000
"""Draws of a block, at least (7.9.4)."""
MOST_TRIALS = 10_000_000
"""An adaptive procedure ends here, stable or not."""
FEWEST_TRIALS = 1_000
SHARE_OF_TOLERANCE = 5.0
"""The draws must be stable to the tolerance over this where they check the law of propagation (8.2)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MonteCarloResult:
    """What the draws say of one quantity.

    Attributes:
        quantity, value, u: mean and standard deviation of the draws.
        low, high: ends of the interval, probabilistically symmetric; shortest: of the shortest one.
        coverage: of both intervals; trials: draws.
        tolerance: numerical tolerance of u to `digits` significant decimal digits, in the unit of the quantity.
        standard_error: of low and high, the larger, by the scatter of the blocks; NaN for a single block.
        draws: (trials,) of the quantity, sorted.
    """

    quantity: str
    value: float
    u: float
    low: float
    high: float
    shortest: tuple[float, float]
    coverage: float
    trials: int
    tolerance: float
    standard_error: float
    draws: Array

    @property
    def stable(self) -> bool:
        """Whether twice the standard error is within the share of the tolerance that a check needs."""
        return 2.0 * self.standard_error <= self.tolerance / SHARE_OF_TOLERANCE


@dataclass(frozen=True, kw_only=True)
class Validation:
    """Whether the law of propagation holds.

    Attributes:
        low_difference, high_difference: of the ends of both intervals; tolerance: that they may differ by.
        holds: both are within it; conclusive: the draws are stable enough to tell.
    """

    low_difference: float
    high_difference: float
    tolerance: float
    conclusive: bool

    @property
    def holds(self) -> bool:
        """Both differences are within the tolerance."""
        return max(self.low_difference, self.high_difference) <= self.tolerance


def numerical_tolerance(u: float, digits: int = 1) -> float:
    """Half a unit of the last of `digits` significant decimal digits of u (7.9.2); 0 for u = 0."""
    if u <= 0.0:
        return 0.0
    rounded = float(f"{u:.{digits - 1}e}")
    return 0.5 * 10.0 ** (math.floor(math.log10(rounded) + 1e-12) - digits + 1)


def monte_carlo(
    model: Model,
    inputs: Sequence[InputQuantity],
    correlations: Correlations | None = None,
    *,
    coverage: float = 0.95,
    trials: int | None = None,
    digits: int = 1,
    seed: int = 0,
    quantity: str = "y",
) -> MonteCarloResult:
    """Draw all inputs of `model(x1, x2, ...)`.

    Args:
        model: a function of arrays; inputs: x1, x2, ...; correlations: between normal inputs, by their names, or
            their matrix.
        coverage: probability of the interval.
        trials: draws; None: blocks until mean, standard deviation and both ends of the interval are stable.
        digits: significant decimal digits of u that count.
        seed: same seed, same draws.
        quantity: name of the result.

    Raises InputError for inputs or correlations that contradict themselves, correlated inputs that are not normal, and
    a model that does not give a number for each draw.
    """
    checked_coverage(coverage)
    if trials is not None and not FEWEST_TRIALS <= trials <= MOST_TRIALS:
        remedy = f"give {FEWEST_TRIALS} to {MOST_TRIALS}, or none for as many as are needed"
        raise InputError(f"{trials} draws", where="trials", remedy=remedy)
    sampler = _Sampler(inputs, correlation_matrix(inputs, correlations), np.random.default_rng(seed))
    block = max(BLOCK, math.ceil(100.0 / (1.0 - coverage))) if trials is None else math.ceil(trials / 10)
    found = _Blocks(coverage, digits)
    while found.trials < (MOST_TRIALS if trials is None else trials):
        count = block if trials is None else min(block, trials - found.trials)
        drawn = results_of(model, sampler.draw(count), (count,))
        if len(drawn) != 1:
            remedy = "give a model of one quantity, or one after the other"
            raise InputError(f"the model returns {len(drawn)} quantities", where="model", remedy=remedy)
        found.add(drawn[0])
        if trials is None and found.stable():
            break
    return found.result(quantity)


def check_law_of_propagation(budget: Budget, drawn: MonteCarloResult) -> Validation:
    """Compare the interval of a budget with that of `drawn`, of the draws (8.1).

    Raises InputError if they are of different coverage.
    """
    if budget.coverage != drawn.coverage:
        what = f"intervals of {budget.coverage:g} and {drawn.coverage:g}"
        raise InputError(what, where=budget.quantity, remedy="give both the same coverage")
    low, high = budget.interval
    return Validation(
        low_difference=abs(low - drawn.low),
        high_difference=abs(high - drawn.high),
        tolerance=drawn.tolerance,
        conclusive=drawn.stable,
    )


class _Sampler:
    """Draws of inputs by their distributions (6.4)."""

    def __init__(self, inputs: Sequence[InputQuantity], correlation: Array, random: np.random.Generator) -> None:
        self._inputs, self._correlation, self._random = inputs, correlation, random
        self._groups = groups(correlation)
        for group in self._groups:
            odd = [inputs[k].name for k in group if inputs[k].distribution != "normal"]
            if len(group) > 1 and odd:
                why = "a correlation coefficient does not determine the joint distribution of others"
                remedy = "declare them as normal, or model what they have in common as an input of its own"
                raise InputError("a correlated input is not normal", where=odd[0], why=why, remedy=remedy)

    def draw(self, count: int) -> list[Array]:
        """(count,) of each input."""
        drawn: list[Array] = [np.empty(0)] * len(self._inputs)
        for group in self._groups:
            for k, deviations in zip(group, self._deviations(group, count), strict=True):
                drawn[k] = self._inputs[k].value + self._inputs[k].u * deviations
        return drawn

    def _deviations(self, group: Sequence[int], count: int) -> Array:
        """Of a group, in standard uncertainties, (len(group), count); of t distributions in their scales."""
        first, random = self._inputs[group[0]], self._random
        if first.distribution != "normal":
            return self._limits(first, count) * self._within(first, count)
        normal = random.standard_normal((len(group), count))
        if len(group) > 1:
            values, vectors = np.linalg.eigh(self._correlation[np.ix_(group, group)])
            normal = (vectors * np.sqrt(np.maximum(values, 0.0))) @ normal
        dof = min(self._inputs[k].dof for k in group)
        return normal if math.isinf(dof) else normal / np.sqrt(random.chisquare(dof, count) / dof)

    def _within(self, one: InputQuantity, count: int) -> Array:
        """Of a distribution with ends, in half-widths, (1, count)."""
        random = self._random
        if one.distribution == "rectangular":
            return random.uniform(-1.0, 1.0, (1, count))
        if one.distribution == "triangular":
            return random.triangular(-1.0, 0.0, 1.0, (1, count))
        return np.sin(random.uniform(0.0, 2.0 * math.pi, (1, count)))

    def _limits(self, one: InputQuantity, count: int) -> Array | float:
        """Half-width in standard uncertainties; with degrees of freedom it is known to a part of 1 / sqrt(2 dof)
        (JCGM 100:2008, G.4.2), within which it is drawn (6.4.3)."""
        if math.isinf(one.dof):
            return SPREAD[one.distribution]
        drawn = self._random.uniform(-1.0, 1.0, (1, count)) / math.sqrt(2.0 * one.dof)
        return SPREAD[one.distribution] * (1.0 + drawn)


class _Blocks:
    """The draws so far, and how much the blocks differ."""

    def __init__(self, coverage: float, digits: int) -> None:
        self._coverage, self._digits = coverage, digits
        self._blocks: list[Array] = []
        self._told: list[tuple[float, float, float, float]] = []

    @property
    def trials(self) -> int:
        """Draws so far."""
        return sum(map(len, self._blocks))

    def add(self, drawn: Array) -> None:
        """A block more."""
        self._blocks.append(drawn)
        ordered = np.sort(drawn)
        self._told.append((float(drawn.mean()), float(drawn.std(ddof=1)), *_symmetric(ordered, self._coverage)))

    def stable(self) -> bool:
        """Whether twice the standard error of all four results is within the share of the tolerance."""
        if len(self._told) < 2:
            return False
        u = float(np.mean([told[1] for told in self._told]))
        return bool(2.0 * self._errors().max() <= numerical_tolerance(u, self._digits) / SHARE_OF_TOLERANCE)

    def _errors(self) -> Array:
        return np.asarray(np.std(self._told, axis=0, ddof=1) / math.sqrt(len(self._told)))

    def result(self, quantity: str) -> MonteCarloResult:
        """Of all draws together."""
        ordered = np.sort(np.concatenate(self._blocks))
        u = float(ordered.std(ddof=1))
        low, high = _symmetric(ordered, self._coverage)
        return MonteCarloResult(
            quantity=quantity,
            value=float(ordered.mean()),
            u=u,
            low=low,
            high=high,
            shortest=_shortest(ordered, self._coverage),
            coverage=self._coverage,
            trials=len(ordered),
            tolerance=numerical_tolerance(u, self._digits),
            standard_error=float(self._errors()[2:].max()) if len(self._told) > 1 else math.nan,
            draws=ordered,
        )


def _covered(ordered: Array, coverage: float) -> int:
    """Draws from the low end of an interval to its high end (7.7.2)."""
    return min(len(ordered) - 1, math.floor(coverage * len(ordered) + 0.5))


def _symmetric(ordered: Array, coverage: float) -> tuple[float, float]:
    q = _covered(ordered, coverage)
    r = (len(ordered) - q) // 2
    return float(ordered[r]), float(ordered[min(r + q, len(ordered) - 1)])


def _shortest(ordered: Array, coverage: float) -> tuple[float, float]:
    """The shortest interval between two draws (7.7.2, note to 5.3.4)."""
    q = _covered(ordered, coverage)
    r = int(np.argmin(ordered[q:] - ordered[: len(ordered) - q]))
    return float(ordered[r]), float(ordered[r + q])
