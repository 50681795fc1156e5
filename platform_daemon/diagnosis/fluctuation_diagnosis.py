"""Diagnoses that a friction explains which fluctuates along each ring-down, with what effects there are beside it."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .diagnosis_result import Diagnosis
from .effect_search import candidates_for
from .effects.effect import Candidate, Detail
from .effects.fluctuation import FRICTION_FLUCTUATION
from .findings.accepted_effects import AcceptedEffect
from .findings.ambiguity import ambiguity_of
from .findings.moving_parameters import moving_parameters
from .findings.next_measurements import proposals
from .findings.notes import undecided
from .findings.rotor_findings import unsearched
from .fluctuation.search import FluctuatingFriction, fluctuating_friction
from .fluctuation.window_courses import window_disagreement_of_courses
from .regression.cross_validation import CrossValidation, cross_validate
from .regression.joint_fit import JointFit, fit_jointly, starting_point
from .regression.parameters import means, widened, window_disagreement
from .regression.score_test import ScoreTable, score_table
from .selection.confounders import confounders, gain_of
from .selection.omnibus_test import omnibus_test
from .selection.significance import log_chance
from .shots.friction_course import dry_friction
from .thresholds import THRESHOLDS


def of_fluctuation(base: JointFit, pool: Executor) -> Diagnosis | None:
    """The diagnosis that a friction explains which fluctuates, without shots, defects of the data, and time.

    base: the fit of the declared model.  None: it explains nothing, or all shots have the same course.
    It is tried before other effects, because some of them imitate its course in each shot, and none in all of them.
    """
    name = dry_friction(base.hypothesis.model)
    dipole = base.prepared[0].shot.record.quantity != "angle"
    if name is None or not dipole or base.chi2_per_dof < THRESHOLDS.regression.noise_chi2_per_dof:
        return None
    candidates = candidates_for(base)
    friction = fluctuating_friction(base, candidates, pool)
    if friction is None:
        return None
    final = friction.joint_fit
    taken = {c.effect for c in final.hypothesis.effects if c.term is not None}
    table = score_table(final, [c for c in candidates if c.effect not in taken], pool)
    before, after = cross_validate(base, pool), cross_validate(final, pool)
    named = (_fluctuation(friction, before, after), *_effects_beside(table, after, float(len(candidates)), pool))
    exact, alike = means(final), [r for n in named for r in n.confounders]
    spanned = widened(exact, [(means(r.joint_fit), r.rise) for r in alike if r.joint_fit is not None])
    rest = omnibus_test(final, pool)
    return Diagnosis(
        shots=(),
        refused=(),
        model=base.hypothesis.model,
        verdict="explained",
        named=named,
        tentative=(),
        why_not="",
        integrity=(),
        found=replace(unsearched(base, pool), best=final, score_table=table, omnibus_test=rest),
        final=final,
        before=before,
        after=after,
        parameters_before=means(base),
        parameters_after=spanned,
        sigma_before=window_disagreement(base, pool),
        sigma_after=window_disagreement_of_courses(final, pool),
        torque=None,
        moving=moving_parameters(base, pool),
        next_measurements=tuple(proposals([ambiguity_of(n, final, pool) for n in named if n.confounders], 0.0)),
        notes=(*_notes(friction, named), *undecided(exact, spanned)),
        seconds=0.0,
    )


def _fluctuation(friction: FluctuatingFriction, before: CrossValidation, after: CrossValidation) -> AcceptedEffect:
    process, likeliest = friction.likeliest.process, friction.likeliest
    return AcceptedEffect(
        candidate=Candidate(FRICTION_FLUCTUATION, Detail(tau_s=process.tau_s)),
        strength=process.share,
        std=process.share * likeliest.log_share_std,
        log_p=log_chance(2.0 * likeliest.log_likelihood, 2),
        held_out_gain=-after.worse_by(before),
        confounders=(),
    )


def _effects_beside(table: ScoreTable, after: CrossValidation, trials: float, pool: Executor) -> list[AcceptedEffect]:
    """The effects that all shots have in common, with their look-alikes."""
    at, found = table.joint_fit, []
    f_nat_hz = sum(s.dynamics.w for s in at.states) / (2.0 * math.pi * len(at.states))
    for c, where in zip(at.hypothesis.common, at.hypothesis.slices, strict=True):
        std = math.sqrt(float(at.covariance[where, where][0, 0]) * at.noise_factor)
        value, std = c.public(float(at.strengths[where][0]), std, f_nat_hz)
        found.append(
            AcceptedEffect(
                candidate=c,
                strength=value,
                std=std,
                log_p=log_chance(gain_of(at, c), c.size, trials * c.trials),
                held_out_gain=_held_out_gain(at, c, after, pool),
                confounders=tuple(r for r in confounders(table, c, pool) if r.indistinguishable),
            )
        )
    return found


def _held_out_gain(at: JointFit, effect: Candidate, after: CrossValidation, pool: Executor) -> float:
    """Fall of the held-out chi^2 by an effect beside the courses; infinite where nothing predicts without it."""
    fewer = at.hypothesis.without(effect)
    try:
        return cross_validate(fit_jointly(at.prepared, fewer, pool, *starting_point(at, fewer)), pool).worse_by(after)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return math.inf


def _notes(friction: FluctuatingFriction, named: tuple[AcceptedEffect, ...]) -> list[str]:
    process, count = friction.likeliest.process, len(friction.joint_fit.prepared)
    lines = [
        f"the friction fluctuates by {100.0 * process.share:.3g} % within a ring-down, with a correlation time of "
        f"{process.tau_s:.2g} s (within a factor {math.exp(friction.likeliest.log_tau_std):.2g}); its course is "
        f"another one in each of the {count} shots, as no law of angle, speed or time is",
        "what the friction does in the next shot cannot be predicted: errors of all parameters, and of the prediction, "
        "count it as noise",
        "N50 is compared with the whole window after the diagnosis, each with courses of the friction of its own",
    ]
    return lines + list(dict.fromkeys(n.candidate.effect.absorbed for n in named if n.candidate.effect.absorbed))
