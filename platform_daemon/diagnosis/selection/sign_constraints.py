"""Sign rules: strengths that physics allows, and losses that must not feed energy into the motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly, starting_point
from platform_daemon.diagnosis.regression.score_test import CandidateBlock, ScoreResult
from platform_daemon.diagnosis.thresholds import THRESHOLDS

_LIMITS = THRESHOLDS.selection


def negative_losses(at: JointFit) -> tuple[int, ...]:
    """Losses of the declared model that come out significantly negative: places among its coefficients."""
    model, count = at.hypothesis.model, len(at.prepared)
    found = []
    for k, coefficient in enumerate(model.coefficients):
        if coefficient.name in model.losses and k not in at.hypothesis.held_at_zero:
            mean = sum(s.dynamics.values[k] for s in at.states) / count
            variance = sum(a.own_covariance()[3 + k, 3 + k] for a in at.linear) / count**2 * at.noise_factor
            if mean < -_LIMITS.negative_loss_sigma * math.sqrt(variance):
                found.append(k)
    return tuple(found)


def without_gain_of_energy(found: JointFit, pool: Executor) -> JointFit:
    """The refit, or another one with the losses that would feed energy into the motion held at 0.

    Raises LostTrajectoryError, LinAlgError.
    """
    negative = negative_losses(found)
    if not negative:
        return found
    held = replace(found.hypothesis, held_at_zero=tuple(sorted({*found.hypothesis.held_at_zero, *negative})))
    return fit_jointly(found.prepared, held, pool, *starting_point(found, held))


def signs_allowed(at: JointFit) -> bool:
    """True if no strength has a sign that physics forbids."""
    pairs = zip(at.hypothesis.common, at.hypothesis.slices, strict=True)
    return all(c.allows(float(at.strengths[s][0])) for c, s in pairs)


def negative_effects(at: JointFit) -> tuple[str, ...]:
    """Named losses whose strengths come out negative, which is allowed only if a larger loss acts too."""
    pairs = zip(at.hypothesis.common, at.hypothesis.slices, strict=True)
    lossy = [(c, s) for c, s in pairs if c.term is not None and c.term.loses_energy]
    return tuple(c.effect.id for c, s in lossy if float(at.strengths[s][0]) < 0.0)


def step_allowed(blocks: Sequence[CandidateBlock], score: ScoreResult) -> bool:
    """The same for a linear step."""
    place = 0
    for b in blocks:
        if not b.candidate.allows(float(score.strengths[place])):
            return False
        place += b.candidate.size
    return True
