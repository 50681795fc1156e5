"""The diagnosis of shots of one specimen: from the residual of the declared model to named effects with evidence."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.one_angle_error import Fitted, one_angle_error, said_of
from platform_daemon.estimation.physics.models import RingDownModel

from .effects.additive import zero_drifts
from .effects.effect import Candidate
from .effects.receiver import receiver_candidates
from .effects.torque import (
    drift_candidate,
    pendulum_candidates,
    settling_candidate,
    stribeck_candidates,
    torque_candidates,
)
from .findings.accepted_effects import AcceptedEffect, accepted_effects, gap_effects, rejected_effects
from .findings.experiment_design import discrimination
from .findings.missing_torque import MissingTorque, missing_torque
from .findings.moving_parameters import MovingParameter, moving_parameters
from .findings.negligible_effects import NegligibleEffect, negligible_effects
from .findings.next_measurements import Ambiguity, Proposal, proposals
from .findings.notes import notes, two_in_place_notes, undecided
from .findings.rotor_findings import (
    leaves_less,
    leaves_noise,
    may_be_a_rotor,
    plane_notes,
    rotor_effect,
    rotor_notes,
    rotor_scores,
    unsearched,
)
from .findings.rotor_parting import parting
from .findings.verdict import assess_diagnosis
from .regression.cross_validation import CrossValidation, cross_validate
from .regression.hypothesis import Hypothesis
from .regression.joint_fit import JointFit, fit_jointly
from .regression.parameters import Mean, means, widened, window_disagreement
from .regression.prediction import unpredicted, window_of
from .report_schema import DiagnosisVerdict
from .rigid_body.defects import ManufacturingError, manufacturing_error
from .rigid_body.plane_test import PlaneTest, plane_test
from .selection.clock_gaps import filled_angles, filled_dipoles
from .selection.component_search import with_tone_free_noise
from .selection.confounders import gain_of
from .selection.data_integrity import DataDefect, data_defects, gap_filled, merged
from .selection.kick_search import kicks
from .selection.omnibus_test import omnibus_test
from .selection.scales import fits_at_neighbouring_scales
from .selection.stepwise import ProgressCallback, Selection, select_effects
from .shots.initial_fits import UnfittedShot, initial_fits, with_beginnings
from .shots.shot import DiagnosisShot, PreparedShot
from .shots.thread_pool import shot_pool
from .thresholds import THRESHOLDS
from .validation.further_shots import further_shots
from .validation.validated_effects import validate_effects

_SEARCHED = 0.7  # share of the progress that the search takes where further shots are tested


class DiagnosisError(ValueError):
    """The shots cannot be diagnosed; the text says why."""


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """The result of a diagnosis, from which reports are made.

    Attributes:
        shots: all shots. refused: those without a fit. model: the declared model. verdict: as in the report.
        named: accepted effects. tentative: effects that gain but were not accepted; why_not: the reason, a sentence.
        integrity: defects of the files and of the data.
        found: the end of the search. final: the joint fit after validation.
        before, after: held-out scores with the declared model and with the final one.
        parameters_before, parameters_after: means by public name, SI; sigma_before, sigma_after: |N50 - D30| over its
            standard error.
        plane: whether the motion leaves the plane of one angle; None: what was recorded does not tell. rotor: the
            manufacturing error that explains that it does; `named`, `verdict`, `after` and `parameters_after` are then
            about it, and `final` is the declared model alone.
        torque: map of the missing torque. moving: parameters that are not constant. notes: sentences for the reader.
        seconds: wall time of the diagnosis, s.
    """

    shots: tuple[DiagnosisShot, ...]
    refused: tuple[UnfittedShot, ...]
    model: RingDownModel
    verdict: DiagnosisVerdict
    named: tuple[AcceptedEffect, ...]
    tentative: tuple[AcceptedEffect, ...]
    why_not: str
    integrity: tuple[DataDefect, ...]
    found: Selection
    final: JointFit
    before: CrossValidation
    after: CrossValidation
    parameters_before: dict[str, Mean]
    parameters_after: dict[str, Mean]
    sigma_before: dict[str, float]
    sigma_after: dict[str, float]
    torque: MissingTorque | None
    moving: tuple[MovingParameter, ...]
    next_measurements: tuple[Proposal, ...]
    notes: tuple[str, ...]
    seconds: float
    plane: PlaneTest | None = None
    rotor: ManufacturingError | None = None

    @property
    def tentative_after(self) -> tuple[AcceptedEffect, ...]:
        """The tentative effects that are part of the final model."""
        keys = {c.key for c in self.final.hypothesis.effects}
        return tuple(n for n in self.tentative if n.candidate.key in keys)


def diagnose_shots(
    shots: Sequence[DiagnosisShot],
    model: RingDownModel,
    progress: ProgressCallback = lambda step, share: None,
    further: Sequence[Callable[[], DiagnosisShot | None]] = (),
    *,
    defects: Sequence[DataDefect] = (),
    remarks: Sequence[str] = (),
) -> Diagnosis:
    """Diagnose shots of one specimen that all obey the same declared model.

    Args:
        shots: ring-downs with their noise, all of one quantity.
        model: the declared model.
        progress: called with the present step in words and the share that is finished.
        further: loaders of shots of the same series on which the result is tested; None from one that cannot be used.
        defects, remarks: of the files that the shots were read from, which come first in the result.

    Raises:
        DiagnosisError: no shot can be fitted by the declared model.

    Example:
        >>> found = diagnose_shots([DiagnosisShot("swing", record, estimate_noise(record))], model_named("thread"))
        >>> diagnosis_report(found).verdict
    """
    began_s = time.perf_counter()
    share = _SEARCHED if further else 1.0

    def searched(step: str, done: float) -> None:
        progress(step, share * done)

    def tested(count: int) -> None:
        progress("shots that were not searched", share + (1.0 - share) * count / len(further))

    with shot_pool() as pool:

        def test(final: JointFit) -> list[str]:
            other = further_shots(final, further, pool, tested)
            return [] if other is None else [other.note]

        return _diagnose(
            list(shots), model, searched, pool, test=test, defects=defects, remarks=remarks, began_s=began_s
        )


def _diagnose(
    shots: list[DiagnosisShot],
    model: RingDownModel,
    progress: ProgressCallback,
    pool: Executor,
    *,
    test: Callable[[JointFit], list[str]],
    defects: Sequence[DataDefect],
    remarks: Sequence[str],
    began_s: float,
) -> Diagnosis:
    """The diagnosis of the searched shots; test: gives sentences on the final fit of shots that were not searched."""
    progress("checks of the data", 0.0)
    prepared, refused, flawed, gaps = _prepared(shots, model, pool)
    progress("fit of the declared model", 0.1)
    swings, hopeless = with_beginnings(prepared, refused, model)
    names = [s.name for s in shots]
    swings.sort(key=lambda s: names.index(s.shot.name))
    plane = plane_test(swings) if swings else None
    if plane is not None and plane.may_leave and (solved := _rotor(swings, model, plane, pool)) is not None:
        declared, rotor = solved
        return replace(
            _of_rotor(declared, plane, rotor, pool),
            shots=tuple(shots),
            refused=tuple(hopeless),
            integrity=(*defects, *flawed, *gaps),
            notes=(*remarks, *test(declared), *plane_notes(plane, shots), *rotor_notes(rotor)),
            seconds=time.perf_counter() - began_s,
        )
    if not prepared:
        why = "; ".join(dict.fromkeys(r.reason for r in refused)) or "; ".join(f.where for f in flawed)
        raise DiagnosisError(f"no shot can be fitted by the declared model {model.name}: {why}")
    if len(swings) > len(prepared):
        plane = plane_test(prepared)
    found, late = _selected(prepared, model, gaps, progress, pool)
    gaps = merged([*gaps, *late])
    progress("prediction of held-out data", 0.8)
    table, before, after, dropped, replaced = validate_effects(found, pool)
    final = table.joint_fit
    if final is not found.best:
        found = replace(found, omnibus_test=omnibus_test(final, pool))
    named = accepted_effects(found, table, after, replaced, pool) if final.hypothesis.effects else ()
    verdict, doubts = assess_diagnosis(found, final, named, gaps, after)
    if plane is not None and not plane.may_leave and may_be_a_rotor(found.base, verdict):
        beside = manufacturing_error(found.base, pool)
        if beside is not None and leaves_less(beside, final, verdict):
            return replace(
                _of_rotor(found.base, plane, beside, pool),
                shots=tuple(shots),
                refused=tuple(refused),
                integrity=(*defects, *flawed, *gaps),
                notes=(*remarks, *test(found.base), *rotor_notes(beside)),
                seconds=time.perf_counter() - began_s,
            )
    tentative, why_not = _not_accepted(found, final, named, doubts) if verdict == "unexplained" else ((), "")
    if verdict == "unexplained":
        named = ()
    progress("parameters before and after", 0.9)
    rest = found.omnibus_test
    torque = missing_torque(final, rest) if verdict in ("unexplained", "partly_explained") else None
    exact, alike = means(final), [r.candidate for n in named for r in n.confounders]
    small = negligible_effects(table, dropped, found.trials, pool) if verdict == "explained" else []
    spanned = widened(exact, _other_explanations(final, named, small, pool))
    spanned, side_modes = _with_side_modes(spanned, prepared[0], model)
    return Diagnosis(
        shots=tuple(shots),
        refused=tuple(refused),
        model=model,
        verdict=verdict,
        named=(*named, *gap_effects(gaps)),
        tentative=tentative,
        why_not=why_not,
        integrity=(*defects, *flawed, *gaps),
        found=found,
        final=final,
        before=before,
        after=after,
        parameters_before=means(found.base),
        parameters_after=spanned,
        sigma_before=window_disagreement(found.base, pool),
        sigma_after=window_disagreement(final, pool),
        torque=torque,
        moving=moving_parameters(found.base, pool),
        next_measurements=tuple(
            proposals(
                [_ambiguity(n, final, pool) for n in named if n.confounders],
                rest.excess if torque is not None else 0.0,
                dipole=shots[0].record.quantity != "angle",
            )
        ),
        notes=(
            *remarks,
            *test(final),
            *plane_notes(plane, shots),
            *notes(found, final, alike, refused, dropped),
            *two_in_place_notes(named),
            *(one.note for one in small[:1]),
            *doubts,
            *undecided(exact, spanned),
            *side_modes,
        ),
        seconds=time.perf_counter() - began_s,
        plane=plane,
    )


def _with_side_modes(
    found: dict[str, Mean], prepared: PreparedShot, model: RingDownModel
) -> tuple[dict[str, Mean], tuple[str, ...]]:
    """Parameters whose errors contain what one angle leaves out of a jewel's rotor with a weight, and a note on it."""
    known, held = prepared.shot.rotor, {p.name: p.fixed for p in model.parameters.values() if p.fixed is not None}
    if known is None or "weight_over_pull" not in held:
        return found, ()
    first, last = window_of(prepared)
    shot = prepared.shot
    fitted = Fitted(model=model, first=first, samples=last - first, rate_hz=shot.rate_hz, sd=shot.noise.sd)
    off = one_angle_error(fitted, {name: m.value for name, m in found.items()}, known, held)
    wider = {name: replace(m, std=math.hypot(m.std, off.get(name, 0.0))) for name, m in found.items()}
    return wider, said_of(off, {name: m.std for name, m in found.items()})


def _rotor(
    prepared: Sequence[PreparedShot], model: RingDownModel, plane: PlaneTest, pool: Executor
) -> tuple[JointFit, ManufacturingError] | None:
    """The declared model's fit, and the manufacturing error that explains what it cannot; None if none does."""
    if any(s.shot.rotor is None for s in prepared):
        return None
    declared = fit_jointly(prepared, Hypothesis(model), pool)
    if not plane.leaves and declared.chi2_per_dof < THRESHOLDS.regression.noise_chi2_per_dof:
        return None
    rotor = manufacturing_error(declared, pool)
    return None if rotor is None else (declared, rotor)


def _of_rotor(base: JointFit, plane: PlaneTest, rotor: ManufacturingError, pool: Executor) -> Diagnosis:
    """The diagnosis that a rotor of five degrees of freedom explains, without shots, defects of the data, and time."""
    before, after = cross_validate(base, pool), rotor_scores(rotor)
    return Diagnosis(
        shots=(),
        refused=(),
        model=base.hypothesis.model,
        verdict="explained" if leaves_noise(rotor) else "partly_explained",
        named=(rotor_effect(rotor, -after.worse_by(before)),),
        tentative=(),
        why_not="",
        integrity=(),
        found=unsearched(base, pool),
        final=base,
        before=before,
        after=after,
        parameters_before=means(base),
        parameters_after=dict(rotor.parameters),
        sigma_before=window_disagreement(base, pool),
        sigma_after={},
        torque=None,
        moving=moving_parameters(base, pool),
        next_measurements=parting(rotor, pool),
        notes=(),
        seconds=0.0,
        plane=plane,
        rotor=rotor,
    )


def _prepared(
    shots: list[DiagnosisShot], model: RingDownModel, pool: Executor
) -> tuple[list[PreparedShot], list[UnfittedShot], list[DataDefect], list[DataDefect]]:
    """Shots with fits of the declared model, shots without one, defects of other shots, gaps that were filled."""
    flawed = data_defects(shots)
    bad = {f.shot for f in flawed}
    usable = [s for k, s in enumerate(shots) if k not in bad]
    angle = shots[0].record.quantity == "angle"
    usable, gaps = filled_angles(usable, pool) if angle else (usable, [])
    prepared, refused = initial_fits(usable, model, pool)
    if prepared and not angle:
        prepared, gaps = filled_dipoles(prepared, model, pool)
    return prepared, refused, flawed, gaps


def _other_explanations(
    final: JointFit, named: Sequence[AcceptedEffect], small: Sequence[NegligibleEffect], pool: Executor
) -> list[tuple[dict[str, Mean], float]]:
    """Parameters in each other model that the data allow, and its rise of chi^2."""
    fits = [(r.joint_fit, r.rise) for n in named for r in n.confounders if r.joint_fit is not None]
    fits += [(other, 1.0) for other in fits_at_neighbouring_scales(final, pool)]
    fits += [(one.joint_fit, 1.0) for one in small]
    return [(means(fit), rise) for fit, rise in fits]


def _not_accepted(
    found: Selection, final: JointFit, named: tuple[AcceptedEffect, ...], doubts: tuple[str, ...]
) -> tuple[tuple[AcceptedEffect, ...], str]:
    """Effects that gain although nothing is explained, and why they were not accepted."""
    if found.rejected is not None and found.rejected.chi2 < final.chi2:
        return rejected_effects(found.rejected, found.trials), "it fits better, but does not predict what was not used"
    return named, doubts[0] if doubts else "together they explain less than half of what is missing"


def _selected(
    prepared: list[PreparedShot],
    model: RingDownModel,
    local: Sequence[DataDefect],
    progress: ProgressCallback,
    pool: Executor,
) -> tuple[Selection, list[DataDefect]]:
    """The selected effects, and clock gaps that only a model of the motion shows.

    A missing effect looks like such gaps, and they look like a missing effect: both are tried, and the smaller residual
    decides.
    """
    found = _effects(prepared, model, progress, pool)
    filled, gaps = gap_filled(prepared, model, pool, local)
    if gaps:
        refilled = _effects(filled, model, progress, pool)
        return (refilled, gaps) if _leaves_less(refilled, found) else (found, [])
    best = found.best
    if not best.hypothesis.torques:
        return found, []
    known = [replace(s, state=best.full_state(k)) for k, s in enumerate(best.prepared)]
    filled, gaps = gap_filled(known, best.hypothesis.augmented, pool, local)
    if not gaps:
        return found, []
    refilled = _effects(
        [replace(m, state=s.state) for m, s in zip(filled, prepared, strict=True)], model, progress, pool
    )
    return (refilled, gaps) if _leaves_less(refilled, found) else (found, [])


def _leaves_less(one: Selection, other: Selection) -> bool:
    """True if one leaves only noise, and significantly less than the other, in units of this noise."""
    if one.best.chi2_per_dof > THRESHOLDS.regression.noise_chi2_per_dof:
        return False
    left = [sum(float(np.sum(unpredicted(s.best, k) ** 2)) for k in range(len(s.best.linear))) for s in (one, other)]
    return left[0] * (1.0 + THRESHOLDS.selection.model_gap_chi2 / one.best.dof) < left[1]


def _effects(
    prepared: Sequence[PreparedShot], model: RingDownModel, progress: ProgressCallback, pool: Executor
) -> Selection:
    """The joint fit of the declared model, and the effects that it lacks."""
    base = with_tone_free_noise(fit_jointly(prepared, Hypothesis(model), pool), pool)
    return select_effects(base, candidates_for(base), pool, progress)


def _ambiguity(named: AcceptedEffect, final: JointFit, pool: Executor) -> Ambiguity:
    """An effect with its look-alikes, and the discrimination that further measurements would bring."""
    effect = named.candidate
    # An effect with a hidden scale is represented by its likeliest value.
    others: dict[object, Candidate] = {}
    accepted = [t.term for t in final.hypothesis.torques]
    for c in (r.candidate for r in named.confounders):
        if c.effect is not effect.effect and (c.term is None or c.term not in accepted):
            others.setdefault((c.effect.id, c.detail) if c.term is None else c.term.name, c)
    alike = tuple(others.values()) or tuple(r.candidate for r in named.confounders if r.candidate.term is effect.term)

    def expected(key: str) -> list[float] | None:
        return discrimination(final, effect, alike, key, pool)

    return Ambiguity(effect=effect, confounders=alike, rise=named.rise, gain=gain_of(final, effect), expected=expected)


def candidates_for(base: JointFit) -> list[Candidate]:
    """Torque and receiver candidates of such shots; the search itself finds additive ones."""
    model, record = base.hypothesis.model, base.prepared[0].shot.record
    if record.quantity == "angle":
        fastest = max(2.0 * s.dynamics.w * math.sin(0.5 * abs(s.dynamics.amplitude)) for s in base.states)
        longest_s = max(float(s.time_s[-1]) for s in base.prepared)
        return [*pendulum_candidates(model, fastest, longest_s), *zero_drifts(longest_s), *kicks(base)]
    small = all(abs(s.dynamics.amplitude) < THRESHOLDS.effects.hertz_law_rad for s in base.states)
    found = [*torque_candidates(model, jewel_law=small), drift_candidate(), *stribeck_candidates(model)]
    # A weak drift too: without it others imitate one that comes to rest.
    found.append(settling_candidate(max(float(s.time_s[-1]) for s in base.prepared)))
    f_nat_hz = float(np.mean([s.dynamics.w for s in base.states])) / (2.0 * math.pi)
    return [*found, *receiver_candidates(record.channels, record.quantity, f_nat_hz)]
