"""The law of propagation of uncertainty for a measurement model given as a function (JCGM 100:2008, 5)."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from drivers.errors import InputError

from .budget import Budget, combine
from .inputs import Array, Correlations, InputQuantity, correlation_matrix, groups

Model = Callable[..., Any]
"""A function of the inputs, in their order, by numpy: given arrays, it returns an array."""
_STEP = 0.5  # first step of the differences, in standard uncertainties: scipy makes it smaller until they agree
_STEP_3 = 0.1  # of third differences: its square against the fifth derivative, 1e-16 over its cube against rounding


@dataclass(frozen=True, eq=False)
class JointBudget(Mapping[str, Budget]):
    """Budgets of several quantities of the same inputs, by name.

    Attributes:
        budgets: in the order in which the model returns the quantities.
        covariance: (m, m) of the quantities, in the products of their units.
    """

    budgets: tuple[Budget, ...]
    covariance: Array

    @property
    def correlation(self) -> Array:
        """Correlation coefficients of the quantities, (m, m)."""
        u = np.sqrt(self.covariance.diagonal())
        return np.asarray(self.covariance / np.outer(u, u))

    def __getitem__(self, name: str) -> Budget:
        found = next((each for each in self.budgets if each.quantity == name), None)
        if found is None:
            raise KeyError(name)
        return found

    def __iter__(self) -> Iterator[str]:
        return iter([each.quantity for each in self.budgets])

    def __len__(self) -> int:
        return len(self.budgets)


def propagate(
    model: Model,
    inputs: Sequence[InputQuantity],
    correlations: Correlations | None = None,
    *,
    coverage: float = 0.95,
    quantity: str = "y",
    second_order: bool = False,
) -> Budget:
    """The budget of `model(x1, x2, ...)`.

    Args:
        model: the function, of floats or arrays.
        inputs: x1, x2, ...
        correlations: between inputs, by their names, or their matrix.
        coverage: probability of the interval value ± U.
        quantity: name of the result.
        second_order: add the terms of the note to 5.1.2, for a model that is not linear over the uncertainties.

    Raises InputError for inputs or correlations that contradict themselves, and for a model without a derivative.
    """
    if not second_order:
        return propagate_jointly(model, inputs, (quantity,), correlations, coverage=coverage)[quantity]
    if len(groups(correlation_matrix(inputs, correlations))) < len(inputs):
        remedy = "leave second_order out, or use monte_carlo, which knows no order"
        raise InputError("the terms of second order hold for independent inputs", where="correlations", remedy=remedy)
    scaled = _in_standard_uncertainties(model, inputs)
    slopes = _jacobian(scaled, len(inputs))
    added = _second_order(lambda z: scaled(z)[0], slopes[0])
    value = float(scaled(np.zeros((len(inputs), 1)))[0, 0])
    u = np.array([each.u for each in inputs])
    return combine(quantity, value, inputs, slopes[0] / u, coverage=coverage, higher_order=added)


def propagate_jointly(
    model: Model,
    inputs: Sequence[InputQuantity],
    quantities: Sequence[str],
    correlations: Correlations | None = None,
    *,
    coverage: float = 0.95,
) -> JointBudget:
    """The budgets of several quantities that one model returns as a tuple, with their covariance.

    The arguments and the errors are those of `propagate`; quantities: names of what the model returns, in order.
    """
    if not inputs:
        raise InputError("the model has no inputs", where="inputs", remedy="give at least one input")
    matrix = correlation_matrix(inputs, correlations)
    scaled = _in_standard_uncertainties(model, inputs)
    values = scaled(np.zeros((len(inputs), 1)))[:, 0]
    if len(values) != len(quantities):
        what = f"the model returns {len(values)} quantities, {len(quantities)} have a name"
        raise InputError(what, where="quantities", remedy="name what the model returns, in its order")
    slopes = _jacobian(scaled, len(inputs))
    u = np.array([each.u for each in inputs])
    budgets = [
        combine(name, value, inputs, row / u, correlations, coverage=coverage)
        for name, value, row in zip(quantities, values, slopes, strict=True)
    ]
    return JointBudget(tuple(budgets), slopes @ matrix @ slopes.T)


def _in_standard_uncertainties(model: Model, inputs: Sequence[InputQuantity]) -> Callable[[Array], Array]:
    """The model, (m, ...), of deviations from the estimates over the standard uncertainties, (n, ...)."""

    def scaled(z: Array) -> Array:
        at = [each.value + each.u * deviation for each, deviation in zip(inputs, z, strict=True)]
        return results_of(model, at, z.shape[1:])

    return scaled


def results_of(model: Model, at: Sequence[Array], shape: tuple[int, ...]) -> Array:
    """What a model returns, (m, *shape).  Raises InputError for what is no finite number, or not one for each place."""
    try:
        with np.errstate(all="ignore"):
            found = model(*at)
        rows = found if isinstance(found, tuple | list) else (found,)
        values = np.stack([np.broadcast_to(np.asarray(row, np.float64), shape) for row in rows])
    except (ValueError, TypeError) as error:
        remedy = "write the model with numpy, so that arrays give arrays"
        raise InputError("the model does not take arrays", where="model", why=str(error), remedy=remedy) from None
    if not np.isfinite(values).all():
        why = "it is evaluated within a few standard uncertainties of the estimates"
        remedy = "restrict the inputs to where the model is defined"
        raise InputError("the model gives no finite number", where="model", why=why, remedy=remedy)
    return values


def _jacobian(scaled: Callable[[Array], Array], n: int) -> Array:
    """Derivatives (m, n) by deviations in standard uncertainties: contributions with their signs."""
    from scipy.differentiate import jacobian

    size, tolerances = _tolerances(scaled, n)
    found = jacobian(scaled, np.zeros(n), tolerances=tolerances, initial_step=_STEP, order=8, maxiter=12)
    # What rounding hides of a derivative: a tiny share of the result for each step.
    rough = ~(found.success | (found.error <= 1e-7 * (np.abs(found.df).max() + 1e-6 * size)))
    if rough.any():
        where = f"model, by input {int(np.argwhere(rough)[0, -1]) + 1}"
        remedy = "use monte_carlo, or a model that is smooth over the uncertainties"
        raise InputError("the model has no derivative at the estimates", where=where, remedy=remedy)
    return np.asarray(found.df, np.float64)


def _tolerances(scaled: Callable[[Array], Array], n: int) -> tuple[float, Any]:
    """Size of the results about the estimates, and how well differences of them need to agree."""
    around = scaled(np.concatenate([np.zeros((n, 1)), np.eye(n), -np.eye(n)], axis=1))
    size = float(np.abs(around).max())
    return size, {"rtol": 1e-9, "atol": 1e-12 * size + 1e-300}


def _second_order(f: Callable[[Array], Array], slopes: Array) -> float:
    """Sum of f_ij^2 / 2 + f_i f_ijj over all i, j: variance by JCGM 100:2008, 5.1.2, note."""
    from scipy.differentiate import hessian

    n = len(slopes)
    _, tolerances = _tolerances(lambda z: f(z)[None], n)
    curvature = np.asarray(hessian(f, np.zeros(n), tolerances=tolerances, initial_step=_STEP).ddf)
    added = 0.5 * float((curvature**2).sum())
    for i, j in itertools.product(range(n), repeat=2):
        if slopes[i] != 0.0:
            added += float(slopes[i]) * _third(f, n, i, j)
    return added


def _third(f: Callable[[Array], Array], n: int, i: int, j: int) -> float:
    """f_ijj by central differences."""
    h = _STEP_3
    steps = [(a, b, a * (1.0 if b else -2.0)) for a in (-1, 1) for b in (-1, 0, 1)]
    at = np.zeros((n, len(steps)))
    for k, (a, b, _) in enumerate(steps):
        at[i, k] += a * h
        at[j, k] += b * h
    return float(f(at) @ np.array([weight for *_, weight in steps])) / (2.0 * h**3)
