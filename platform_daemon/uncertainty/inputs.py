"""What a measurement model is fed with: quantities with their standard uncertainties, and how they are correlated."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from drivers.errors import InputError

Array = NDArray[np.float64]
Distribution = Literal["normal", "rectangular", "triangular", "arcsine"]
Correlations = Mapping[tuple[str, str], float] | Sequence[Sequence[float]] | Array
"""Correlation coefficients by the names of two inputs, of which a pair that is not named has none; or their matrix
(n, n), in the order of the inputs."""
SPREAD: dict[str, float] = {"rectangular": math.sqrt(3.0), "triangular": math.sqrt(6.0), "arcsine": math.sqrt(2.0)}
"""Half-width over standard deviation (JCGM 100:2008, 4.3.7, 4.3.9; JCGM 101:2008, 6.4.6)."""
_NEGATIVE = -1e-9  # an eigenvalue of a correlation matrix that rounding explains


@dataclass(frozen=True, kw_only=True)
class InputQuantity:
    """An input of a measurement model.

    Attributes:
        name: by which budgets list it and correlations name it.
        value: best estimate; u: standard uncertainty, in the unit of the value.
        kind: "A", evaluated from repeated observations, or "B", from anything else.
        distribution: of what it may be; "normal" with finite `dof` is a scaled and shifted t distribution, one with
            ends has ends that are not exactly known.
        dof: degrees of freedom of `u`; infinite: it is known exactly.
        source: where it is known from, in words.

    Raises InputError for u that is not above 0, dof below 1, what is no finite number, or an unknown kind or
    distribution.
    """

    name: str
    value: float
    u: float
    kind: Literal["A", "B"] = "B"
    distribution: Distribution = "normal"
    dof: float = math.inf
    source: str = ""

    def __post_init__(self) -> None:
        for number in (self.value, self.u, self.dof):
            if not isinstance(number, Real):
                raise InputError(f"{number!r} is no number", where=self.name, remedy="give numbers")
        if not math.isfinite(self.value):
            raise InputError(f"the value is {self.value}", where=self.name, remedy="give a finite number")
        if not (math.isfinite(self.u) and self.u > 0.0):
            why = "an influence without uncertainty is a constant of the model, and a negative one is no uncertainty"
            remedy = "give a standard uncertainty above 0, or leave the input out, so that it is listed as not declared"
            raise InputError(f"the standard uncertainty is {self.u}", where=self.name, why=why, remedy=remedy)
        if not self.dof >= 1.0:
            raise InputError(f"{self.dof} degrees of freedom", where=self.name, remedy="give 1 or more, or none")
        if self.kind not in ("A", "B"):
            remedy = "A: evaluated from repeated observations; B: from anything else"
            raise InputError(f"no type {self.kind!r} of evaluation", where=self.name, remedy=remedy)
        if self.distribution != "normal" and self.distribution not in SPREAD:
            remedy = f"one of: normal, {', '.join(SPREAD)}"
            raise InputError(f"no distribution {self.distribution!r}", where=self.name, remedy=remedy)

    @classmethod
    def within(
        cls,
        name: str,
        value: float,
        half_width: float,
        distribution: Distribution = "rectangular",
        *,
        dof: float = math.inf,
        source: str = "",
    ) -> InputQuantity:
        """One that lies within value ± half_width.  Raises InputError as the class does, and for a normal one."""
        if distribution not in SPREAD:
            remedy = f"give its standard uncertainty, or one of: {', '.join(SPREAD)}"
            raise InputError(f"{distribution} has no half-width", where=name, remedy=remedy)
        u = half_width / SPREAD[distribution]
        return cls(name=name, value=value, u=u, distribution=distribution, dof=dof, source=source)


def from_observations(
    observations: Mapping[str, Sequence[float]], *, source: str = ""
) -> tuple[tuple[InputQuantity, ...], dict[tuple[str, str], float]]:
    """Means of quantities that were observed together, with their correlations (JCGM 100:2008, 4.2 and 5.2.3).

    Args:
        observations: of each quantity by name, all of one length of at least 2, in the order in which they were made.
        source: where they are known from.

    Returns the inputs, of type A with n - 1 degrees of freedom, and the coefficients between them.  Raises InputError
    for no quantity, lengths that differ, fewer than two observations, what is no finite number, or observations that
    are all one.
    """
    if not observations:
        raise InputError("there are no observations", where="observations", remedy="give those of each quantity")
    table: dict[str, Array] = {}
    for name, given in observations.items():
        try:
            table[name] = values = np.asarray(given, np.float64)
        except (ValueError, TypeError) as error:
            raise InputError("not all are numbers", where=name, why=str(error), remedy="give numbers") from None
        if values.shape != next(iter(table.values())).shape or values.ndim != 1 or values.size < 2:
            remedy = "give as many observations of each quantity, at least two"
            raise InputError(f"observations of the shape {values.shape}", where=name, remedy=remedy)
        if not np.isfinite(values).all():
            raise InputError("an observation is no finite number", where=name, remedy="leave the observation out")
    n = next(iter(table.values())).size
    inputs = tuple(
        InputQuantity(
            name=name,
            value=float(values.mean()),
            u=float(values.std(ddof=1)) / math.sqrt(n),
            kind="A",
            dof=n - 1.0,
            source=source or f"mean of {n} observations",
        )
        for name, values in table.items()
    )
    between = {(a, b): float(np.corrcoef(table[a], table[b])[0, 1]) for a, b in itertools.combinations(table, 2)}
    return inputs, between


def correlation_matrix(inputs: Sequence[InputQuantity], correlations: Correlations | None) -> Array:
    """The matrix (n, n) of the correlation coefficients.

    Raises InputError for two inputs of one name, a name that is no input's, a coefficient outside -1 to 1, two of one
    pair that differ, one of an input with itself, a matrix that is not square, symmetric or 1 on its diagonal, and for
    coefficients that no joint distribution can have.
    """
    names = [each.name for each in inputs]
    doubles = sorted({name for name in names if names.count(name) > 1})
    if doubles:
        raise InputError(f"several inputs are called {', '.join(doubles)}", remedy="give each input its own name")
    pairs = correlations if isinstance(correlations, Mapping) else _pairs_of(names, correlations)
    matrix = np.eye(len(names))
    given: dict[frozenset[str], float] = {}
    for (one, other), r in pairs.items():
        where = f"correlation of {one} and {other}"
        unknown = [name for name in (one, other) if name not in names]
        if unknown:
            raise InputError(f"no input {unknown[0]!r}", where=where, remedy=f"one of: {', '.join(names)}")
        if one == other:
            raise InputError("an input is correlated with itself by 1", where=where, remedy="name two inputs")
        if not -1.0 <= r <= 1.0:
            raise InputError(f"the coefficient is {r}", where=where, remedy="give a number between -1 and 1")
        i, j = names.index(one), names.index(other)
        if (before := given.setdefault(frozenset((one, other)), r)) != r:
            raise InputError(f"{before:g} and {r:g} are both given", where=where, remedy="give one of the two")
        matrix[i, j] = matrix[j, i] = r
    smallest = float(np.linalg.eigvalsh(matrix)[0]) if pairs else 1.0
    if smallest < _NEGATIVE:
        concerned = sorted({name for pair, r in pairs.items() if r != 0.0 for name in pair})
        raise InputError(
            "the correlation coefficients contradict each other",
            where=", ".join(concerned),
            why=f"their matrix has the eigenvalue {smallest:.3g}, which no joint distribution has",
            remedy="make the coefficients smaller, or estimate all of them from the same observations",
        )
    return matrix


def _pairs_of(names: Sequence[str], matrix: Sequence[Sequence[float]] | Array | None) -> dict[tuple[str, str], float]:
    """Every element beside the diagonal of a matrix (n, n).  Raises InputError for one that is none of coefficients."""
    if matrix is None:
        return {}
    where, n = "correlations", len(names)
    try:
        rows = np.asarray(matrix, np.float64)
    except (ValueError, TypeError) as error:
        remedy = "give coefficients by pairs of names, or their matrix"
        raise InputError("not all are numbers", where=where, why=str(error), remedy=remedy) from None
    if rows.shape != (n, n):
        remedy = f"give one of {n} by {n}, in the order of the inputs, or coefficients by pairs of names"
        raise InputError(f"a matrix of the shape {rows.shape} for {n} inputs", where=where, remedy=remedy)
    for name, r in zip(names, rows.diagonal(), strict=True):
        if r != 1.0:
            remedy = "give coefficients: a covariance over both standard uncertainties"
            raise InputError(f"the diagonal holds {r:g} for {name}, not 1", where=where, remedy=remedy)
    return {(names[i], names[j]): float(rows[i, j]) for i, j in itertools.permutations(range(n), 2)}


def groups(correlation: Array) -> list[list[int]]:
    """Places of inputs that are correlated with each other, directly or through others."""
    if np.count_nonzero(correlation) == len(correlation):  # of itself, each of them
        return [[k] for k in range(len(correlation))]
    label = np.arange(len(correlation))  # of scipy, connected_components takes longer than the rest of a budget
    for one, other in zip(*np.nonzero(np.triu(correlation, 1)), strict=True):
        first, second = sorted((label[one], label[other]))
        label[label == second] = first
    return [np.flatnonzero(label == k).tolist() for k in np.unique(label)]
