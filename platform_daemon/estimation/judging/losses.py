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
_SEEN = 2.0  # standard deviations
_SURELY = 3.0


@dataclass(frozen=True)
class Tangle:
    """Two losses of which a window determines the sum only.

    Attributes:
        names: the losses, the one with the smaller relative error first.
        correlation: of their errors.
    """

    names: tuple[str, str]
    correlation: float


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
    return Tangle((better, worse), correlation)


def tangle_warning(tangle: Tangle, enough_s: float | None) -> str:
    """Losses that the window cannot tell apart; enough_s: the window that would, None if there is no such."""
    if enough_s is None:
        longer = "the motion ends before a longer window tells them"
    else:
        longer = f"or lengthen the window to about {_rounded_up(enough_s):.2g} s"
    return (
        f"lambda_tf_not_separable: the window determines only the sum of {' and '.join(tangle.names)} "
        f"(correlation {tangle.correlation:.4f}); fix or hint one, {longer}"
    )


def _rounded_up(seconds: float) -> float:
    """To two digits."""
    step = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return math.ceil(seconds / step) * step


def loss_warnings(model: RingDownModel, public: Published, tangle: Tangle | None) -> Iterator[str]:
    """Losses that feed energy in, or that are not there."""
    for name in model.losses:
        loss = public.parameters[name]
        if loss.std is None:
            continue
        if loss.value < -_SURELY * loss.std:
            yield f"negative_loss: {name} = {loss.value:.4g} +- {loss.std:.2g} feeds energy in"
        elif loss.value < _SEEN * loss.std and tangle is None:
            yield f"loss_not_seen: {name} = {loss.value:.4g} +- {loss.std:.2g}; the record is explained without it"
