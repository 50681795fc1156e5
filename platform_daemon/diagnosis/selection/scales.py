"""Hidden scales of accepted effects by refits: where chi^2 is least, and how the strength moves with the scale.

The valley of a friction that falls with the speed is narrow and bent: its strength, its velocity scale and the viscous
loss follow each other. Steps along it are taken in all of them together.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.estimation import Array, LostTrajectoryError

from ..effects.effect import Candidate
from ..regression.hypothesis import Hypothesis
from ..regression.information import solved
from ..regression.joint_fit import JointFit, fit_jointly
from ..regression.linearised_shot import LinearisedShot, common_information
from ..shots.linearisation import linearise_signal
from .sign_constraints import without_gain_of_energy

_MOST_STEPS = 8
_FURTHEST = math.log(2.5)  # of one step in the logarithm of a scale
_SETTLED = 0.02  # of that logarithm
_VARIED = (0.7, 0.9, 1.1, 1.4)  # times a scale, to see what moves with it


def at_best_scales(at: JointFit, pool: Executor) -> JointFit:
    """The joint fit with every scale that has limits where chi^2 is least between them."""
    for c in at.hypothesis.torques:
        if c.scale_limits is not None:
            at = _at_best_scale(at, c.effect.id, pool)
    return at


def _at_best_scale(at: JointFit, effect: str, pool: Executor) -> JointFit:
    """Gauss-Newton on one scale, shorter where it would not go down."""
    for _ in range(_MOST_STEPS):
        c = next(t for t in at.hypothesis.torques if t.effect.id == effect)
        assert c.scale_limits is not None
        step, common = _step(at, c, pool)
        low, high = (math.log(limit / c.hidden[0]) for limit in c.scale_limits)
        for fraction in (1.0, 0.3, 0.1):
            moved = min(max(fraction * step, low, -_FURTHEST), high, _FURTHEST)
            if abs(moved) < _SETTLED:
                return at
            found = with_scale(at, c, c.hidden[0] * math.exp(moved), pool, moved / step * common)
            if found is not None and found.chi2 < at.chi2:
                break
        else:
            return at
        settled = at.chi2 - found.chi2 < _SETTLED * max(1.0, found.chi2_per_dof)
        at = found
        if settled:
            break
    return at


def _step(at: JointFit, c: Candidate, pool: Executor) -> tuple[float, Array]:
    """(of the logarithm of the scale, of the common strengths (q,)), to first order."""
    place = at.hypothesis.strength_places()[at.hypothesis.torques.index(c)] + 1
    wide = list(pool.map(lambda k: _beside_scale(at, k, place, c.hidden[0]), range(len(at.linear))))
    step = solved(*common_information(wide, at.hypothesis.size + 1))
    return float(step[-1]), step[:-1]


def _beside_scale(at: JointFit, k: int, place: int, scale: float) -> LinearisedShot:
    """Shot k with the scale's logarithm as a further common strength."""
    a, model = at.linear[k], at.hypothesis.augmented
    column = scale * linearise_signal(at.started[k], model, at.full_state(k)).base[place]
    column = column - a.own @ (a.own.T @ column)
    return replace(a, columns=np.column_stack([a.columns, column]))


def with_scale(
    at: JointFit, like: Candidate, scale: float, pool: Executor, common: Array | None = None
) -> JointFit | None:
    """The joint fit with another scale of an effect; None where the motion is lost.

    common: step of the strengths (q,) that goes with it; None: none.
    """
    assert like.at_scale is not None
    other, step = like.at_scale(scale), np.zeros(at.hypothesis.size) if common is None else common
    effects: Sequence[Candidate] = [other if c.effect is like.effect else c for c in at.hypothesis.effects]
    hypothesis: Hypothesis = replace(at.hypothesis, effects=tuple(effects), gone=())
    try:
        begun = fit_jointly(at.started, hypothesis, pool, at.states, at.strengths + step)
        return without_gain_of_energy(begun, pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None


def strength_spread(at: JointFit, c: Candidate, pool: Executor) -> float:
    """By how much a strength moves with its scale, per standard deviation of the latter."""
    here, spread = _strength(at, c), 0.0
    for times in _VARIED:
        found = with_scale(at, c, c.hidden[0] * times, pool)
        if found is not None:
            rise = (found.chi2 - at.chi2) / at.noise_factor
            spread = max(spread, abs(_strength(found, c) - here) / math.sqrt(max(rise, 1.0)))
    return spread


def _strength(at: JointFit, like: Candidate) -> float:
    pairs = zip(at.hypothesis.common, at.hypothesis.slices, strict=True)
    return next(float(at.strengths[s][0]) for c, s in pairs if c.effect is like.effect)
