"""Diagnoses of shots whose friction or frequency fluctuates along each ring-down, and the effects beside it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .diagnosis_result import Diagnosis
from .effect_search import candidates_for, declared_fit
from .effects.effect import Candidate, Detail
from .effects.fluctuation import FREQUENCY_FLUCTUATION
from .findings.accepted_effects import AcceptedEffect
from .findings.ambiguity import ambiguity_of
from .findings.moving_parameters import moving_parameters
from .findings.next_measurements import proposals
from .findings.notes import undecided
from .findings.rotor_findings import unsearched
from .findings.undeclared_weight import with_undeclared_weight
from .fluctuation.flat_noise import with_flat_noise
from .fluctuation.fluctuating import Fluctuating
from .fluctuation.search import FoundFluctuation, fits_at_neighbouring_processes, fluctuation_of
from .fluctuation.window_courses import window_disagreement_of_courses
from .regression.cross_validation import CrossValidation, cross_validate
from .regression.joint_fit import JointFit, fit_jointly, starting_point
from .regression.parameters import Mean, means, widened, window_disagreement, with_scales
from .regression.score_test import ScoreTable, score_table
from .selection.confounders import confounders, gain_of
from .selection.sign_constraints import negative_losses
from .selection.significance import log_chance
from .shots.shot import PreparedShot
from .thresholds import THRESHOLDS

_FLAT = (
    "the noise was not measured in blank shots, and between the harmonics stand the widened lines of the signal: the "
    "noise is taken for flat, of the level far above them"
)


def may_fluctuate(prepared: Sequence[PreparedShot]) -> bool:
    """True for shots in which a fluctuation is sought: two or more of a dipole."""
    return len(prepared) > 1 and prepared[0].shot.record.quantity != "angle"


def fitted_shots(prepared: Sequence[PreparedShot], most: int) -> list[PreparedShot]:
    """Of a long series so many, evenly spread, as memory and time allow: each has a course of its own."""
    return [prepared[round(at)] for at in np.linspace(0, len(prepared) - 1, min(len(prepared), most))]


def of_fluctuation(
    prepared: Sequence[PreparedShot], model: RingDownModel, what: Fluctuating, pool: Executor
) -> Diagnosis | None:
    """The diagnosis of shots in which something fluctuates, without shots, defects of the data, and time.

    prepared: the shots that are fitted.  None: it explains nothing, or all shots have the same course.
    It is tried before other effects, because some of them imitate its course in each shot, and none in all of them.
    """
    base = declared_fit(prepared, model, pool)
    if base.chi2_per_dof < THRESHOLDS.regression.noise_chi2_per_dof:
        return None
    flat = with_flat_noise(prepared)
    found = None if flat is None else _of_fluctuation(declared_fit(flat, model, pool), what, pool)
    return _of_fluctuation(base, what, pool) if found is None else replace(found, notes=(*found.notes, _FLAT))


def _of_fluctuation(base: JointFit, what: Fluctuating, pool: Executor) -> Diagnosis | None:
    """base: the fit of the declared model."""
    candidates = candidates_for(base)
    found = fluctuation_of(base, what, candidates, pool)
    if found is None:
        return None
    try:
        return _told(base, found, candidates, pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None


def _told(base: JointFit, found: FoundFluctuation, candidates: Sequence[Candidate], pool: Executor) -> Diagnosis:
    """What there is beside the fluctuation, and what it changes.  Raises LostTrajectoryError."""
    final = found.joint_fit
    torques = {c.effect for c in final.hypothesis.torques}
    keys = {c.key for c in final.hypothesis.effects}
    table = score_table(final, [c for c in candidates if c.effect not in torques and c.key not in keys], pool)
    before, after = cross_validate(base, pool), cross_validate(final, pool)
    named = (_fluctuation(found, before, after), *_effects_beside(table, after, float(len(candidates)), pool))
    neighbours = [(means(moved), times) for moved, times in fits_at_neighbouring_processes(found, pool)]
    exact = _with_scatter(with_scales(means(final), neighbours), final)
    alike = [r for n in named for r in n.confounders]
    spanned = widened(exact, [(means(r.joint_fit), r.rise) for r in alike if r.joint_fit is not None])
    wider, weight = with_undeclared_weight(spanned, final)
    doubts = _doubts(final, named, after)
    return Diagnosis(
        shots=(),
        refused=(),
        model=base.hypothesis.model,
        verdict="partly_explained" if doubts else "explained",
        named=named,
        tentative=(),
        why_not="",
        integrity=(),
        found=replace(unsearched(base, pool), best=final, score_table=table),
        final=final,
        before=before,
        after=after,
        parameters_before=means(base),
        parameters_after=wider,
        sigma_before=window_disagreement(base, pool),
        sigma_after=window_disagreement_of_courses(final, pool),
        torque=None,
        moving=moving_parameters(base, pool),
        next_measurements=tuple(proposals([ambiguity_of(n, final, pool) for n in named if n.confounders], 0.0)),
        notes=(*_notes(found, named), *undecided(exact, spanned), *doubts, *weight),
        seconds=0.0,
    )


def _with_scatter(found: Mapping[str, Mean], final: JointFit) -> dict[str, Mean]:
    """Parameters, with errors of the resonator's constants not below what their scatter from shot to shot says.

    A course takes up part of what tells a constant; which part goes with the form of the process, which is not known.
    """
    constants = {"f_nat_hz", "m_r_am2", *(c.name for c in final.hypothesis.model.coefficients)}
    root = math.sqrt(len(final.prepared))
    return {
        name: replace(m, std=max(m.std, m.scatter / root)) if name in constants and m.scatter is not None else m
        for name, m in found.items()
    }


def _doubts(final: JointFit, named: Sequence[AcceptedEffect], after: CrossValidation) -> list[str]:
    """Why the effects do not explain everything."""
    doubts = []
    if after.total.chi2_per_dof > THRESHOLDS.regression.noise_chi2_per_dof:
        doubts.append(f"held-out data are predicted to chi2/dof {after.total.chi2_per_dof:.3g} only")
    doubts += [
        f"{final.hypothesis.model.coefficients[k].name} comes out negative, which physics forbids"
        for k in negative_losses(final)
    ]
    doubts += [
        f"{n.candidate.effect.id} gains in the fit but not on held-out data"
        for n in named[1:]
        if n.held_out_gain <= 0.0
    ]
    return doubts


def _fluctuation(found: FoundFluctuation, before: CrossValidation, after: CrossValidation) -> AcceptedEffect:
    process, likeliest = found.likeliest.process, found.likeliest
    return AcceptedEffect(
        candidate=Candidate(found.what.effect, Detail(tau_s=process.tau_s)),
        strength=process.size,
        std=process.size * likeliest.log_size_std,
        log_p=log_chance(2.0 * likeliest.log_likelihood, 2),
        held_out_gain=-after.worse_by(before),
        confounders=(),
        log_scale_std=likeliest.log_tau_std if found.tau_is_determined else math.inf,
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


def _notes(found: FoundFluctuation, named: tuple[AcceptedEffect, ...]) -> list[str]:
    likeliest, count = found.likeliest, len(found.joint_fit.prepared)
    process = likeliest.process
    what, size = found.what.noun, f"{100.0 * process.size:.3g} %"
    if found.what.effect is FREQUENCY_FLUCTUATION:
        size = f"{process.size:.3g} Hz"
    within = "not determined: the data tell the square of the size over it"
    if found.tau_is_determined:
        within = f"within a factor {math.exp(likeliest.log_tau_std):.2g}"
    lines = [
        f"the {what} fluctuates by {size} within a ring-down, with a correlation time of "
        f"{process.tau_s:.2g} s ({within}); its course is "
        f"another one in each of the {count} shots, as no law of angle, speed or time is",
        f"what the {what} does in the next shot cannot be predicted: errors of all parameters, and of the prediction, "
        "count it as noise",
    ]
    return lines + list(dict.fromkeys(n.candidate.effect.absorbed for n in named if n.candidate.effect.absorbed))
