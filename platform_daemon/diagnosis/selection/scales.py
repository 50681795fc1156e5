"""Hidden scales of accepted effects by refits: where chi^2 is least, and how the strength moves with the scale.

The valley of a friction that falls with the speed is narrow and bent: its strength, its velocity scale and the viscous
loss follow each other. Steps along it are taken in all of them together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.information import inverse, solved
from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly
from platform_daemon.diagnosis.regression.linearised_shot import LinearisedShot, common_information
from platform_daemon.diagnosis.shots.linearisation import linearise_signal
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .sign_constraints import without_gain_of_energy

_LIMITS = THRESHOLDS.selection


def at_best_scales(at: JointFit, pool: Executor) -> JointFit:
    """The joint fit with every scale that has limits where chi^2 is least between them."""
    for c in at.hypothesis.torques:
        if c.scale_limits is not None:
            at = _at_best_scale(at, c.effect.id, pool)
    return at


@dataclass(frozen=True)
class _Along:
    """A joint fit to first order with the logarithm of one scale as a further common strength, the last.

    Attributes:
        shots: with its column. step: (q + 1,) to the least chi^2. covariance: (q + 1, q + 1), of white noise.
    """

    at: JointFit
    effect: Candidate
    shots: tuple[LinearisedShot, ...]
    step: Array
    covariance: Array

    def stepped(self, step: Array) -> tuple[float, list[FitState], Array]:
        """(scale, states, strengths) after a step (q + 1,), the shots' own parameters following it."""
        states = [s.moved(a.own_step(step)) for s, a in zip(self.at.states, self.shots, strict=True)]
        return self.effect.hidden[0] * math.exp(step[-1]), states, self.at.strengths + step[:-1]

    def following(self, moved: float) -> Array:
        """Step (q + 1,) whose scale moves so far, and everything else with it."""
        return np.asarray(self.covariance[:, -1] / self.covariance[-1, -1] * moved)


def _along(at: JointFit, c: Candidate, pool: Executor) -> _Along:
    """Raises LostTrajectoryError."""
    place = at.hypothesis.strength_places()[at.hypothesis.torques.index(c)] + 1
    wide = tuple(pool.map(lambda k: _with_scale_column(at, k, place, c.hidden[0]), range(len(at.linear))))
    matrix, gradient = common_information(wide, at.hypothesis.size + 1)
    return _Along(at, c, wide, solved(matrix, gradient), inverse(matrix))


def _at_best_scale(at: JointFit, effect: str, pool: Executor) -> JointFit:
    """Gauss-Newton on one scale, shorter where it would not go down."""
    for _ in range(_LIMITS.scale_steps):
        c = next(t for t in at.hypothesis.torques if t.effect.id == effect and t.scale_limits is not None)
        assert c.scale_limits is not None
        along = _along(at, c, pool)
        step, settled = float(along.step[-1]), _LIMITS.settled_scale_chi2 * max(1.0, at.chi2_per_dof)
        low, high = (math.log(limit / c.hidden[0]) for limit in c.scale_limits)
        for fraction in _LIMITS.scale_fractions:
            moved = min(max(fraction * step, low, -_LIMITS.furthest_log_scale), high, _LIMITS.furthest_log_scale)
            if moved * (2.0 * step - moved) <= settled * along.covariance[-1, -1]:
                return at
            found = _with_scale(along, moved / step * along.step, pool)
            if found is not None and found.chi2 < at.chi2:
                break
        else:
            return at
        fall, at = at.chi2 - found.chi2, found
        if fall < settled:
            break
    return at


def _with_scale_column(at: JointFit, k: int, place: int, scale: float) -> LinearisedShot:
    """Shot k with the scale's logarithm as a further common strength."""
    a, model = at.linear[k], at.hypothesis.augmented
    column = scale * linearise_signal(at.prepared[k], model, at.full_state(k)).base[place]
    column = column - a.own @ (a.own.T @ column)
    return replace(a, columns=np.column_stack([a.columns, column]))


def _with_scale(along: _Along, step: Array, pool: Executor) -> JointFit | None:
    """The joint fit with another scale of an effect; None where the motion is lost."""
    at, like = along.at, along.effect
    assert like.at_scale is not None
    scale, states, strengths = along.stepped(step)
    other = like.at_scale(scale)
    effects: Sequence[Candidate] = [other if c.key == like.key else c for c in at.hypothesis.effects]
    hypothesis: Hypothesis = replace(at.hypothesis, effects=tuple(effects), held_at_zero=())
    try:
        return without_gain_of_energy(fit_jointly(at.prepared, hypothesis, pool, states, strengths), pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None


def spread_by_other_scales(at: JointFit, pool: Executor) -> Array:
    """By how much each strength (q,) moves with the scales of other effects per standard deviation of these.

    To first order, and not further than a scale may step; two effects of one friction, one of which has a scale, are
    known together.
    """
    squares = np.zeros(at.hypothesis.size)
    for c in at.hypothesis.torques:
        if c.scale_limits is None:
            continue
        try:
            along = _along(at, c, pool)
        except LostTrajectoryError:
            continue
        sd = min(math.sqrt(along.covariance[-1, -1] * at.noise_factor), _LIMITS.furthest_log_scale)
        if sd > 0.0:  # else nothing tells the scale
            moved = along.following(sd)[:-1]
            moved[_column(at, c)] = 0.0
            squares += moved**2
    return np.sqrt(squares)


def scale_errors(at: JointFit, c: Candidate, pool: Executor) -> tuple[float, float]:
    """(by how much a strength moves with its scale per standard deviation of the latter, that of its logarithm).

    The first to first order where the scale is well known, or where a refit agrees, and by refits where its valley is
    bent; the second always to first order.
    """
    along = _along(at, c, pool)
    sd = math.sqrt(along.covariance[-1, -1] * at.noise_factor)
    straight = abs(float(along.following(sd)[_column(at, c)]))
    if 0.0 < sd < _LIMITS.known_log_scale:
        return straight, sd
    near = min(max(_LIMITS.checked_sigma * sd, _LIMITS.known_log_scale), _LIMITS.furthest_log_scale)
    spread = _spread_at(along, near, pool)
    if spread is not None and abs(spread - straight) < _LIMITS.straight_share * straight:
        return max(spread, straight), sd
    found = [_spread_at(along, math.log(times), pool) for times in _LIMITS.varied_scales]
    return max([s for s in (spread, *found) if s is not None], default=0.0), sd


def _spread_at(along: _Along, moved: float, pool: Executor) -> float | None:
    """Change of the strength with the logarithm of its scale moved so far, per root of what chi^2 rises by."""
    at, c = along.at, along.effect
    found = _with_scale(along, along.following(moved), pool)
    if found is None:
        return None
    rise = (found.chi2 - at.chi2) / at.noise_factor
    return abs(_strength(found, c) - _strength(at, c)) / math.sqrt(max(rise, 1.0))


def fits_at_neighbouring_scales(at: JointFit, pool: Executor) -> list[tuple[JointFit, float]]:
    """For each hidden scale with limits the same fit with that scale a standard deviation away, to first order.

    Its states and strengths follow.  A scale that is hardly known moves by less; the number is how many such moves a
    standard deviation has.
    """
    found = []
    for c in at.hypothesis.torques:
        if c.scale_limits is not None and c.at_scale is not None:
            along = _along(at, c, pool)
            sd = math.sqrt(along.covariance[-1, -1] * at.noise_factor)
            moved = min(sd, _LIMITS.furthest_log_scale)
            if moved == 0.0:
                continue
            scale, states, strengths = along.stepped(along.following(moved))
            other = c.at_scale(scale)
            effects = tuple(other if e.key == c.key else e for e in at.hypothesis.effects)
            hypothesis = replace(at.hypothesis, effects=effects)
            found.append((replace(at, hypothesis=hypothesis, states=tuple(states), strengths=strengths), sd / moved))
    return found


def _strength(at: JointFit, like: Candidate) -> float:
    return float(at.strengths[_column(at, like)])


def _column(at: JointFit, like: Candidate) -> int:
    """Of an effect's strength among the common ones, whatever its scale."""
    pairs = zip(at.hypothesis.common, at.hypothesis.slices, strict=True)
    return next(s.start for c, s in pairs if c.term is like.term)
