"""Doubts about fitted losses: sources of energy, losses that are not there, losses that cannot be told apart."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

from ..least_squares.publish import Published
from ..models import RingDownModel

_TANGLED = 0.99  # correlation
_UNSEPARATED = 0.2  # relative error of either
_SEPARATED = 0.1  # relative error of a loss that is told apart from the other
_SEPARATION_POWER = 1.0 / 2.7  # that error falls at least with the length of the window to the power of 2.7
_SEEN = 2.0  # standard deviations
_SURELY = 3.0


@dataclass(frozen=True)
class Tangle:
    """Two losses of which a window determines the sum only.

    Attributes:
        names: the losses, the one with the smaller relative error first.
        correlation: of their errors.
        relative_error: of the first one.
    """

    names: tuple[str, str]
    correlation: float
    relative_error: float


def tangled_losses(model: RingDownModel, public: Published) -> Tangle | None:
    """The pair of free losses with the largest correlation, if the window cannot tell them apart.

    It cannot where the errors of the two are nearly opposite and both are uncertain by more than a fifth.
    """
    free = [n for n in model.losses if n in public.names]
    found = [t for pair in combinations(free, 2) if (t := _tangle(public, *pair)) is not None]
    return max(found, key=lambda t: abs(t.correlation), default=None)


def _tangle(public: Published, one: str, other: str) -> Tangle | None:
    """The pair, if the window cannot tell it apart."""
    i, j = public.names.index(one), public.names.index(other)
    covariance = public.covariance
    correlation = float(covariance[i, j] / math.sqrt(covariance[i, i] * covariance[j, j]))
    errors = {
        name: math.sqrt(covariance[k, k]) / max(abs(public.parameters[name].value), 1e-300)
        for name, k in ((one, i), (other, j))
    }
    better, worse = sorted(errors, key=lambda name: errors[name])
    if abs(correlation) < _TANGLED or errors[better] < _UNSEPARATED:
        return None
    return Tangle((better, worse), correlation, errors[better])


def separating_window_s(tangle: Tangle, window_s: float) -> float:
    """The window, in s, that would tell the two losses apart."""
    return window_s * max(1.5, (tangle.relative_error / _SEPARATED) ** _SEPARATION_POWER)


def loss_warnings(model: RingDownModel, public: Published, tangle: Tangle | None, window_s: float) -> Iterator[str]:
    """Losses that the window cannot tell apart, that feed energy in, or that are not there."""
    if tangle is not None:
        yield (
            f"lambda_tf_not_separable: the window determines only the sum of {' and '.join(tangle.names)} "
            f"(correlation {tangle.correlation:.4f}); fix one, or lengthen the window to about "
            f"{separating_window_s(tangle, window_s):.2g} s"
        )
    for name in model.losses:
        loss = public.parameters[name]
        if loss.std is None:
            continue
        if loss.value < -_SURELY * loss.std:
            yield f"negative_loss: {name} = {loss.value:.4g} +- {loss.std:.2g} feeds energy in"
        elif loss.value < _SEEN * loss.std and tangle is None:
            yield f"loss_not_seen: {name} = {loss.value:.4g} +- {loss.std:.2g}; the record is explained without it"
