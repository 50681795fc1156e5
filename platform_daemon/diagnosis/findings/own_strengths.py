"""Strengths that differ from shot to shot: where common ones leave something, every shot has its own.

A torque of which each shot has its own strength is a term of the model, as viscous damping is: its coefficient is
fitted for each shot, and predicted from the other shots within their scatter.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.cross_validation import CrossValidation, cross_validate
from platform_daemon.diagnosis.regression.hypothesis import Hypothesis
from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly, starting_strengths
from platform_daemon.diagnosis.selection.confounders import Confounder
from platform_daemon.diagnosis.selection.sign_constraints import negative_losses, signs_allowed
from platform_daemon.diagnosis.selection.significance import LEVEL, log_chance
from platform_daemon.diagnosis.selection.stepwise import Selection
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.physics.models import Parameter, RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .accepted_effects import AcceptedEffect
from .shot_strengths import ShotStrengths

_LIMITS = THRESHOLDS.validation


@dataclass(frozen=True, kw_only=True)
class OwnStrengths:
    """A fit in which every shot has its own strengths of some torques.

    Attributes:
        fit: its hypothesis has the declared model with these torques as terms. held_out: its score.
        named: the torques, each with the mean over the shots. told: the strengths of every shot.
    """

    fit: JointFit
    held_out: CrossValidation
    named: tuple[AcceptedEffect, ...]
    told: ShotStrengths


def own_strengths(found: Selection, final: JointFit, after: CrossValidation, pool: Executor) -> OwnStrengths | None:
    """Own strengths of the accepted torques, or of other ones where common strengths explain none; None: no gain.

    final: the joint fit with common strengths, after: its held-out score.
    """
    count = len(final.prepared)
    if count < _LIMITS.fewest_own_strengths:
        return None
    accepted = [c for c in final.hypothesis.torques if _possible(c)]
    freed = _grown(final, accepted, count - 1, found.trials, pool)
    if freed is None and not final.leaves_noise:
        possible = [t.candidates[0] for t in found.tried if _possible(t.candidates[0])]
        freed = _grown(found.base, possible, count, found.trials, pool)
    if freed is None or not (freed[0].leaves_noise or freed[0].chi2 < _LIMITS.own_strength_share * final.chi2):
        return None
    fit, own = freed
    held_out = cross_validate(fit, pool)
    worse = held_out.worse_by(after) >= 0.0 if fit.leaves_noise else held_out.total.nrmse >= after.total.nrmse
    return None if worse else _told(found, final, fit, own, held_out, pool)


def _possible(c: Candidate) -> bool:
    """A torque of one strength of its own, which may be a term of a model."""
    return c.term is not None and not c.of and c.size == 1 and not c.term.timed


def _grown(
    start: JointFit, offered: Sequence[Candidate], parameters: int, trials: float, pool: Executor
) -> tuple[JointFit, list[Candidate]] | None:
    """One torque after the other gets strengths of each shot's own, the best first, as long as the gain is sure.

    parameters: that each of them adds.
    """
    at, own = start, list[Candidate]()
    for _ in range(THRESHOLDS.selection.largest_set):
        rest = [c for c in offered if all(c.effect is not o.effect for o in own)]
        fits = [(f, c) for c in rest if (f := _freed(at, c, pool)) is not None]
        if not fits:
            break
        best, chosen = min(fits, key=lambda pair: pair[0].chi2)
        fall = (at.chi2 - best.chi2) / best.noise_factor
        if log_chance(fall, parameters, trials) >= LEVEL:
            break
        at, own = best, [*own, chosen]
    return (at, own) if own else None


def _freed(at: JointFit, c: Candidate, pool: Executor) -> JointFit | None:
    """The fit with the strength of one torque each shot's own; None if a sign is forbidden or the motion is lost."""
    known = [k for k, e in enumerate(at.hypothesis.common) if e.key == c.key]
    begin = float(at.strengths[at.hypothesis.slices[known[0]]][0]) if known else 0.0
    model = _with_term(at.hypothesis.model, c)
    kept = tuple(e for e in at.hypothesis.effects if e.key != c.key)
    hypothesis = Hypothesis(model, kept, at.hypothesis.held_at_zero)
    prepared = [replace(s, state=_extended(s.state, 0.0, c)) for s in at.prepared]
    states = [_extended(s, begin, c) for s in at.states]
    try:
        fit = fit_jointly(prepared, hypothesis, pool, states, starting_strengths(at, hypothesis))
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None
    allowed = all(c.allows(v) for v in _values(fit, c)) and not negative_losses(fit) and signs_allowed(fit)
    return fit if allowed and fit.chi2 < at.chi2 else None


def _with_term(model: RingDownModel, c: Candidate) -> RingDownModel:
    """The model with the torque as a term whose hidden scale is held."""
    assert c.term is not None
    scales = zip(c.term.coefficients[1:], c.hidden, strict=True)
    held = tuple(Parameter(q.name, q.unit, fixed=value) for q, value in scales)
    extended = model.with_terms(f"{model.name}+{c.term.name}", c.term)
    return replace(extended, known=(*extended.known, *held))


def _extended(state: FitState, strength: float, c: Candidate) -> FitState:
    return replace(state, dynamics=replace(state.dynamics, values=(*state.dynamics.values, float(strength), *c.hidden)))


def _place(at: JointFit, c: Candidate) -> int:
    """Of the torque's strength among the coefficients of the model."""
    assert c.term is not None
    return [q.name for q in at.hypothesis.model.coefficients].index(c.term.coefficients[0].name)


def _values(at: JointFit, c: Candidate) -> list[float]:
    """Strengths of the shots."""
    return [float(s.dynamics.values[_place(at, c)]) for s in at.states]


def _told(
    found: Selection, common: JointFit, fit: JointFit, own: Sequence[Candidate], held_out: CrossValidation,
    pool: Executor,
) -> OwnStrengths:  # fmt: skip
    """The torques with their strengths, and how much each of them explains."""
    named, rows = [], []
    for c in own:
        others = [o for o in own if o is not c]
        without: JointFit | None = found.base
        for o in others:
            without = None if without is None else _freed(without, o, pool)
        without = without or found.base
        values = [c.public(v, 0.0, s.dynamics.w / (2.0 * math.pi))[0] for v, s in
                  zip(_values(fit, c), fit.states, strict=True)]  # fmt: skip
        place = 3 + _place(fit, c)
        errors = [math.sqrt(a.own_covariance()[place, place] * fit.noise_factor) for a in fit.linear]
        spread = max(float(np.std(values, ddof=1)), float(np.sqrt(np.mean(np.square(errors)))))
        fall = max(without.chi2 - fit.chi2, 0.0) / fit.noise_factor
        named.append(
            AcceptedEffect(
                candidate=c,
                strength=float(np.mean(values)),
                std=spread / math.sqrt(len(values)),
                log_p=log_chance(fall, len(values), found.trials),
                held_out_gain=cross_validate(without, pool).worse_by(held_out),
                confounders=_look_alikes(found, without, fit, c, fall, pool),
            )
        )
        rows.append(values)
    told = ShotStrengths(
        effects=tuple(own),
        shots=tuple(s.shot.name for s in fit.prepared),
        values=np.array(rows).T,
        together=common.chi2,
        alone=fit.chi2,
    )
    return OwnStrengths(fit=fit, held_out=held_out, named=tuple(named), told=told)


def _look_alikes(
    found: Selection, without: JointFit, fit: JointFit, effect: Candidate, gain: float, pool: Executor
) -> tuple[Confounder, ...]:
    """Torques that take the place of one, with each shot's own strength too."""
    taken = {e.term for e in fit.hypothesis.effects} | set(fit.hypothesis.model.terms)
    alike = []
    for c in dict.fromkeys(t.candidates[0] for t in found.tried):
        if not _possible(c) or c.term in taken or (other := _freed(without, c, pool)) is None:
            continue
        rise = (other.chi2 - fit.chi2) / fit.noise_factor
        if rise < THRESHOLDS.selection.told_apart_chi2:
            alike.append(Confounder(candidate=c, rise=rise, gain=gain))
    return tuple(alike)
