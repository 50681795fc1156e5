"""The budget of a result: what each input contributes, and what it all adds up to (JCGM 100:2008, 5 and G)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from drivers.errors import InputError

from .inputs import Array, Correlations, InputQuantity, correlation_matrix, groups


@dataclass(frozen=True)
class Contribution:
    """A line of a budget.

    Attributes:
        input: what contributes; sensitivity: change of the result per change of it, in the quotient of their units.
    """

    input: InputQuantity
    sensitivity: float

    @property
    def contribution(self) -> float:
        """|sensitivity| u, in the unit of the result."""
        return abs(self.sensitivity) * self.input.u


@dataclass(frozen=True)
class NotDeclared:
    """An influence that nobody has declared: the budget does not contain it.

    Attributes:
        name: of the influence, with the unit that it counts in.
        would_add_per_unit: |sensitivity|: standard uncertainty of the result for each such unit; NaN: not known.
        looked_for: it was tested, and less than its own error was seen.
    """

    name: str
    would_add_per_unit: float
    looked_for: bool = False


@dataclass(frozen=True, kw_only=True)
class Budget:
    """The uncertainty budget of one quantity.

    Attributes:
        quantity, value: of the result; u: combined standard uncertainty, in its unit.
        dof: effective degrees of freedom (Welch and Satterthwaite, JCGM 100:2008, G.4); infinite: u is known exactly.
        k: coverage factor, the quantile of the t distribution of `dof`, cut to a whole number (G.4.1).
        coverage: probability with which value ± U covers the quantity.
        contributions: a line for each input, in the order in which they were given.
        correlations: coefficients between inputs.
        not_declared: what is not contained.
        higher_order: variance of the terms of second order, if they were asked for, and contained in u.
    """

    quantity: str
    value: float
    u: float
    dof: float
    k: float
    coverage: float
    contributions: tuple[Contribution, ...]
    correlations: tuple[tuple[str, str, float], ...] = ()
    not_declared: tuple[NotDeclared, ...] = ()
    higher_order: float = 0.0

    @property
    def expanded(self) -> float:
        """U = k u."""
        return self.k * self.u

    @property
    def interval(self) -> tuple[float, float]:
        """From value - U to value + U."""
        return self.value - self.expanded, self.value + self.expanded

    def by_contribution(self) -> tuple[Contribution, ...]:
        """The lines, the largest first."""
        return tuple(sorted(self.contributions, key=lambda line: -line.contribution))


def checked_coverage(coverage: float) -> float:
    """Raises InputError for what is no probability of a coverage interval."""
    if not 0.0 < coverage < 1.0:
        remedy = "give a probability between 0 and 1, as 0.95"
        raise InputError(f"the coverage is {coverage}", where="coverage", remedy=remedy)
    return coverage


def coverage_factor(coverage: float, dof: float = math.inf) -> float:
    """k for a two-sided interval, by the t distribution of `dof`, cut to the next lower whole number."""
    from scipy.special import ndtri, stdtrit

    tail = 0.5 + 0.5 * checked_coverage(coverage)
    return float(ndtri(tail) if math.isinf(dof) else stdtrit(max(1, math.floor(dof + 1e-9)), tail))


def combine(
    quantity: str,
    value: float,
    inputs: Sequence[InputQuantity],
    sensitivities: Array,
    correlations: Correlations | None = None,
    *,
    coverage: float = 0.95,
    not_declared: Sequence[NotDeclared] = (),
    higher_order: float = 0.0,
) -> Budget:
    """The budget of a result whose sensitivities are known.

    Args:
        quantity, value: of the result.
        inputs: (n); sensitivities: (n,), by each of them.
        correlations: between inputs.
        coverage: probability of the interval value ± U.
        not_declared: see Budget.  higher_order: variance of the terms of second order.

    Inputs that are correlated count as one for the effective degrees of freedom, with the smallest of theirs: it is
    exact where they come from the same observations (JCGM 100:2008, H.2), and otherwise too few rather than too many.

    Raises InputError as `correlation_matrix` does, and for a coverage that is no probability.
    """
    matrix = correlation_matrix(inputs, correlations)
    u = np.array([each.u for each in inputs])
    parts = np.asarray(sensitivities, np.float64) * u
    variance = float(parts @ matrix @ parts) + higher_order
    dof = _effective_dof(inputs, parts, matrix, variance)
    return Budget(
        quantity=quantity,
        value=float(value),
        u=math.sqrt(max(0.0, variance)),
        dof=dof,
        k=coverage_factor(coverage, dof),
        coverage=coverage,
        contributions=tuple(map(Contribution, inputs, np.asarray(sensitivities, np.float64).tolist())),
        correlations=tuple(
            (inputs[i].name, inputs[j].name, float(matrix[i, j]))
            for i, j in zip(*np.nonzero(matrix), strict=True)
            if i < j
        ),
        not_declared=tuple(not_declared),
        higher_order=higher_order,
    )


def _effective_dof(inputs: Sequence[InputQuantity], parts: Array, matrix: Array, variance: float) -> float:
    """Equation (G.2b) over groups of correlated inputs."""
    per_dof = 0.0
    for group in groups(matrix):
        own = float(parts[group] @ matrix[np.ix_(group, group)] @ parts[group])
        per_dof += own**2 / min(inputs[k].dof for k in group)
    return variance**2 / per_dof if per_dof > 0.0 else math.inf
