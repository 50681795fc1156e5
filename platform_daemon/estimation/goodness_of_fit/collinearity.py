"""Doubts about fitted losses: sources of energy, losses that are not there, losses that cannot be separated."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.problem import FitProblem
from platform_daemon.estimation.least_squares.public_parameters import PublicParameters
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.thresholds import THRESHOLDS

from .residual import Residual
from .residual_jacobian import derivatives_of

LIMITS = THRESHOLDS.goodness_of_fit
_POINTS = np.array(LIMITS.separating_points)  # of that reach


@dataclass(frozen=True)
class CollinearLosses:
    """Two losses of which a window determines the sum only.

    Attributes:
        names: the losses, the one with the smaller relative error first.
        correlation: of their errors.
    """

    names: tuple[str, str]
    correlation: float


def collinear_losses(model: RingDownModel, public: PublicParameters) -> CollinearLosses | None:
    """The pair of free losses with the largest correlation, if the window cannot separate them.

    It cannot where the errors of the two are nearly opposite and both are uncertain by more than a fifth.
    """
    free = [n for n in model.losses if n in public.names]
    found = [t for pair in combinations(free, 2) if (t := _collinear(public, *pair)) is not None]
    return max(found, key=lambda t: abs(t.correlation), default=None)


def _collinear(public: PublicParameters, one: str, other: str) -> CollinearLosses | None:
    """The pair, if the window cannot separate it."""
    i, j = public.names.index(one), public.names.index(other)
    covariance = public.covariance
    correlation = float(covariance[i, j] / math.sqrt(covariance[i, i] * covariance[j, j]))
    errors = {
        name: math.sqrt(covariance[k, k]) / max(abs(public.parameters[name].value), 1e-300)
        for name, k in ((one, i), (other, j))
    }
    better, worse = sorted(errors, key=lambda name: errors[name])
    if abs(correlation) < LIMITS.collinear_correlation or errors[better] < LIMITS.collinear_share:
        return None
    return CollinearLosses((better, worse), correlation)


def collinearity_warning(tangle: CollinearLosses, enough_s: float | None) -> str:
    """Losses that the window cannot separate; enough_s: the window that would, None if there is no such."""
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


def loss_warnings(model: RingDownModel, public: PublicParameters, tangle: CollinearLosses | None) -> Iterator[str]:
    """Losses that feed energy in, or that are not there."""
    for name in model.losses:
        loss = public.parameters[name]
        if loss.std is None:
            continue
        if loss.value < -LIMITS.negative_loss_sigma * loss.std:
            yield f"negative_loss: {name} = {loss.value:.4g} +- {loss.std:.2g} feeds energy in"
        elif loss.value < LIMITS.loss_seen_sigma * loss.std and tangle is None:
            yield f"loss_not_seen: {name} = {loss.value:.4g} +- {loss.std:.2g}; the record is explained without it"


def separating_window_s(
    problem: FitProblem, state: FitState, residual: Residual, public: PublicParameters, tangle: CollinearLosses
) -> float | None:
    """The window in s, or None if the motion ends before the two losses can be separated.

    Their sum is known, and neither is negative; the longer window has to determine their shares, for any shares.
    """
    names = [c.name for c in problem.model.coefficients]
    places = [names.index(name) for name in tangle.names]
    stds = np.array([public.parameters[name].std or 0.0 for name in tangle.names])
    sizes = _plausible(public, tangle, stds)
    values = list(state.dynamics.values)
    for place, size in zip(places, sizes[:, _POINTS.size // 2].tolist(), strict=True):
        values[place] = size
    state = replace(state, dynamics=replace(state.dynamics, values=tuple(values)))
    for look in LIMITS.separating_looks:
        try:
            found = _errors(problem, state, residual, [3 + place for place in places], look)
        except (LostTrajectoryError, np.linalg.LinAlgError):
            return None
        # What the noise's colour does to the errors, it does in longer windows too.
        scale = stds / found[0][1]
        for window_s, sd, correlation in found:
            if _is_told((scale * sd)[:, None] / sizes, correlation):
                return window_s
    return None


def _plausible(public: PublicParameters, tangle: CollinearLosses, stds: Array) -> Array:
    """Values of the two losses, (2, points), along their well-known sum: neither negative, not far from the fit."""
    one, other = (public.parameters[name].value for name in tangle.names)
    slope = -float(stds[1] / stds[0])
    # From where one of them is 0 to where the other is.
    first, last = sorted([-one, -other / slope])
    # Beyond either end of the reach there is a standard deviation at least, if the sum leaves room for it.
    low, high = (
        min(-LIMITS.separating_reach_sigma * stds[0], last - stds[0]),
        max(LIMITS.separating_reach_sigma * stds[0], first + stds[0]),
    )
    low, high = max(first, low), min(last, high)
    aside = low + (high - low) * _POINTS
    return np.maximum(np.array([one + aside, other + slope * aside]), LIMITS.least_loss_sigma * stds[:, None])


def _is_told(relative: Array, correlation: float) -> bool:
    """Past the rule by which losses are called inseparable, at every point; neither lost in its error in the middle.

    relative: (2, points) errors.
    """
    better = bool(np.all(relative.min(axis=0) < LIMITS.separated_share))
    better = better or abs(correlation) < LIMITS.separated_correlation
    return better and float(relative[:, _POINTS.size // 2].max()) < LIMITS.separated_other_share


def _errors(
    problem: FitProblem, state: FitState, residual: Residual, losses: list[int], look: float
) -> list[tuple[float, Array, float]]:
    """(window in s, errors of the two losses, their correlation) for the window itself and ever longer ones."""
    step_s, blocks = 1.0 / residual.rate_hz, residual.scaled.shape[1]
    first = round(problem.first * problem.record.dt_s / step_s)
    ends = (
        blocks * LIMITS.separating_step ** np.arange(int(np.log(look) / np.log(LIMITS.separating_step)) + 1)
    ).astype(int)
    # A dozen samples per period hold as much information as all of them, with less noise each.
    rows = derivatives_of(problem.model, state, first=first, blocks=int(ends[-1]), block=1, dt_s=step_s)[problem.free]
    rows = rows / residual.sd[:, None]
    where = [int(np.count_nonzero(problem.free[:k])) for k in losses]
    fisher, begin, found = np.zeros((rows.shape[0], rows.shape[0])), 0, []
    for end in ends.tolist():
        piece = rows[..., begin:end].reshape(rows.shape[0], -1)
        fisher, begin = fisher + piece @ piece.T, end
        pair = _inverse(fisher)[np.ix_(where, where)]
        sd = np.sqrt(pair.diagonal())
        found.append(((first + end) * step_s, sd, float(pair[0, 1] / (sd[0] * sd[1]))))
    return found


def _inverse(fisher: Array) -> Array:
    """Scaled to unit diagonal first."""
    scale = 1.0 / np.sqrt(fisher.diagonal())
    return np.asarray(np.linalg.inv(fisher * np.outer(scale, scale)) * np.outer(scale, scale))
