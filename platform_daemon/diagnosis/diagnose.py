"""The diagnosis of shots of one specimen: from the residual of the declared model to named effects with evidence."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

from platform_daemon.estimation.physics.models import RingDownModel

from .diagnosis_result import Diagnosis
from .effect_search import selected_effects
from .effects.effect import Candidate
from .findings.accepted_effects import AcceptedEffect, accepted_effects, gap_effects, not_accepted
from .findings.ambiguity import ambiguity_of
from .findings.missing_torque import missing_torque
from .findings.moving_parameters import moving_parameters
from .findings.negligible_effects import NegligibleEffect, negligible_effects
from .findings.next_measurements import proposals
from .findings.notes import notes, two_in_place_notes, undecided
from .findings.own_strengths import OwnStrengths, own_strengths
from .findings.rotor_findings import (
    hidden_error_notes,
    leaves_less,
    may_be_a_rotor,
    may_be_imitated,
    plane_notes,
)
from .findings.shot_strengths import strengths_by_shot
from .findings.side_modes import with_side_modes
from .findings.undeclared_weight import with_undeclared_weight
from .findings.verdict import assess_diagnosis
from .fluctuation.fluctuating import what_may_fluctuate
from .fluctuation_diagnosis import fitted_shots, may_fluctuate, of_fluctuation
from .regression.cross_validation import CrossValidation
from .regression.joint_fit import JointFit
from .regression.parameters import (
    Mean,
    means,
    widened,
    window_differences,
    with_scales,
    with_what_is_left,
)
from .regression.score_test import ScoreTable
from .report_schema import DiagnosisVerdict
from .rigid_body.plane_test import PlaneTest, plane_test
from .rotor_diagnosis import of_rotor
from .rotor_search import RotorBeside, rotor_of
from .selection.clock_gaps import filled_angles, filled_dipoles
from .selection.data_integrity import DataDefect, after_clipping, data_defects, merged
from .selection.omnibus_test import omnibus_test
from .selection.scales import fits_at_neighbouring_scales
from .selection.stale_samples import without_stale_samples
from .selection.stepwise import ProgressCallback, Selection
from .shots.initial_fits import UnfittedShot, initial_fits, with_beginnings
from .shots.memory import give_large_arrays_back
from .shots.shot import DiagnosisShot, PreparedShot, as_measured
from .shots.thread_pool import shot_pool
from .validation.further_shots import further_shots
from .validation.validated_effects import validate_effects

_SEARCHED = 0.7  # share of the progress that the search takes where further shots are tested


class DiagnosisError(ValueError):
    """The shots cannot be diagnosed; the text says why."""


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
        further: loaders of shots of the same series on which the result is tested, unless it is a rotor or a friction
            that fluctuates; None from one that cannot be used.
        defects, remarks: of the files that the shots were read from, which come first in the result.

    Large arrays of the process go back to the operating system when they are freed from then on, which glibc does not
    do by itself.

    Raises:
        DiagnosisError: no shot can be fitted by the declared model.

    Example:
        >>> found = diagnose_shots([DiagnosisShot("swing", record, estimate_noise(record))], model_named("thread"))
        >>> diagnosis_report(found).verdict
    """
    began_s = time.perf_counter()
    give_large_arrays_back()
    share = _SEARCHED if further else 1.0

    def searched(step: str, done: float) -> None:
        progress(step, share * done)

    def tested(count: int) -> None:
        progress("shots that were not searched", share + (1.0 - share) * count / len(further))

    with shot_pool() as pool:

        def test(final: JointFit | str) -> list[str]:
            if isinstance(final, str):
                return [f"{final} is not tried on the {len(further)} shots that were not searched"] if further else []
            other = further_shots(final, further, pool, tested, model)
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
    test: Callable[[JointFit | str], list[str]],
    defects: Sequence[DataDefect],
    remarks: Sequence[str],
    began_s: float,
) -> Diagnosis:
    """Of the searched shots; test: sentences on the shots that were not, by the final fit or what cannot be tried."""
    progress("checks of the data", 0.0)
    prepared, refused, flawed, gaps = _prepared(shots, model, pool)
    progress("fit of the declared model", 0.1)
    swings, hopeless = with_beginnings(prepared, refused, model)
    names = [s.name for s in shots]
    swings.sort(key=lambda s: names.index(s.shot.name))
    plane = plane_test(swings) if swings else None

    def whole(
        of: Diagnosis, said: Sequence[str], without: Sequence[UnfittedShot], damaged: Sequence[DataDefect]
    ) -> Diagnosis:
        return replace(
            of,
            shots=tuple(shots),
            refused=tuple(without),
            integrity=(*defects, *flawed, *damaged),
            notes=(*remarks, *said, *of.notes),
            seconds=time.perf_counter() - began_s,
            plane=plane,
        )

    if plane is not None and plane.may_leave:
        progress("a rotor of five degrees of freedom", 0.15)
        solved = rotor_of(swings, model, plane, pool)
        if solved is not None:
            by_rotor = of_rotor(solved[0], plane, solved[1], pool, searched=False)
            return whole(by_rotor, [*test("a rotor"), *plane_notes(plane, shots)], hopeless, gaps)
    if not prepared:
        why = "; ".join(dict.fromkeys(r.reason for r in refused)) or "; ".join(f.where for f in flawed)
        raise DiagnosisError(f"no shot can be fitted by the declared model {model.name}: {why}")
    if len(swings) > len(prepared):
        plane = plane_test(prepared)
    for what in what_may_fluctuate(model) if not gaps and may_fluctuate(prepared) else ():
        progress(f"a {what.noun} that may fluctuate", 0.15)
        some = fitted_shots(prepared, what.most_shots)
        by_course = of_fluctuation(some, model, what, pool)
        if by_course is not None:
            more = len(some) < len(prepared)
            fitted = [f"of {len(prepared)} shots {len(some)}, evenly spread, are fitted"] if more else []
            own_course = f"a {what.noun} that fluctuates, in each shot by a course of its own,"
            return whole(by_course, [*fitted, *test(own_course), *plane_notes(plane, shots)], refused, ())
    with RotorBeside(plane, pool) as beside:
        found, late = selected_effects(prepared, model, gaps, progress, pool, beside.begin)
        gaps = merged([*gaps, *late])
        ended = _rotor_or_effects(found, beside, gaps, progress, pool)
    if isinstance(ended, Diagnosis):
        return whole(ended, test("a rotor"), refused, gaps)
    progress("parameters before and after", 0.9)
    by_effects = _of_effects(ended, prepared[0], model, gaps, refused, pool)
    return whole(by_effects, [*test(ended.final), *plane_notes(plane, shots)], refused, gaps)


@dataclass(frozen=True, kw_only=True)
class _Searched:
    """The search and its final fit after validation, with the scores, the names and what is doubted."""

    found: Selection
    table: ScoreTable
    final: JointFit
    before: CrossValidation
    after: CrossValidation
    dropped: tuple[Candidate, ...]
    named: tuple[AcceptedEffect, ...]
    verdict: DiagnosisVerdict
    doubts: tuple[str, ...]
    own: OwnStrengths | None


def _validated(found: Selection, gaps: Sequence[DataDefect], pool: Executor) -> _Searched:
    table, before, after, dropped, replaced = validate_effects(found, pool)
    final = table.joint_fit
    own = own_strengths(found, final, after, pool)
    if own is not None:
        table, after, final = found.score_table_of(own.fit), own.held_out, own.fit
    if final is not found.best:
        found = replace(found, omnibus_test=omnibus_test(final, pool))
    named = accepted_effects(found, table, after, replaced, pool) if final.hypothesis.effects else ()
    named = (*own.named, *named) if own is not None else named
    verdict, doubts = assess_diagnosis(found, final, named, gaps, after)
    return _Searched(
        found=found,
        table=table,
        final=final,
        before=before,
        after=after,
        dropped=dropped,
        named=named,
        verdict=verdict,
        doubts=doubts,
        own=own,
    )


def _rotor_or_effects(
    found: Selection,
    beside: RotorBeside,
    gaps: Sequence[DataDefect],
    progress: ProgressCallback,
    pool: Executor,
) -> Diagnosis | _Searched:
    """A rotor that leaves less than the effects of one angle, as a diagnosis, or these with their evidence."""
    base = found.base

    def by_rotor(plane: PlaneTest, final: JointFit, verdict: DiagnosisVerdict) -> Diagnosis | None:
        rotor = beside.of(base)
        if rotor is None or not leaves_less(rotor, final, verdict):
            return None
        return of_rotor(base, plane, rotor, pool, searched=True)

    untried = beside.untried(base)
    if untried is not None and not base.leaves_noise and may_be_imitated(found.best):
        # The evidence for each torque takes longer than the rotor, and only a rotor that leaves more needs it.
        progress("a rotor of five degrees of freedom", 0.8)
        by_errors = by_rotor(untried, found.best, "explained")
        if by_errors is not None:
            return by_errors
    progress("prediction of held-out data", 0.85)
    searched = _validated(found, gaps, pool)
    if untried is not None and may_be_a_rotor(base, searched.verdict, searched.named):
        return by_rotor(untried, searched.final, searched.verdict) or searched
    return searched


def _of_effects(
    searched: _Searched,
    first: PreparedShot,
    model: RingDownModel,
    gaps: Sequence[DataDefect],
    refused: Sequence[UnfittedShot],
    pool: Executor,
) -> Diagnosis:
    """The diagnosis by effects on one angle, without shots, defects of the data, time, and notes on further shots."""
    found, final, verdict, named = searched.found, searched.final, searched.verdict, searched.named
    tentative, why_not = not_accepted(found, final, named, searched.doubts) if verdict == "unexplained" else ((), "")
    unknown = verdict == "unexplained" and searched.own is None
    own = strengths_by_shot(found.rejected or found.best, pool) if unknown else None
    differ = own is not None and own.differ
    why_not = "its strength differs from shot to shot" if differ else why_not
    if verdict == "unexplained":
        named = ()
    rest = found.omnibus_test
    torque = missing_torque(final, rest) if verdict in ("unexplained", "partly_explained") else None
    exact = with_scales(
        means(final), [(means(moved), times) for moved, times in fits_at_neighbouring_scales(final, pool)]
    )
    alike = [r.candidate for n in named for r in n.confounders]
    small = negligible_effects(searched.table, searched.dropped, found.trials, pool) if verdict == "explained" else []
    spanned = widened(exact, _other_explanations(named, small))
    wider, side_modes = with_side_modes(spanned, first, model)
    wider, weight = with_undeclared_weight(wider, final)
    declared, apart = window_differences(found.base, pool), window_differences(final, pool)
    left = list[str]()
    if verdict in ("unexplained", "partly_explained"):
        # Where what is left is so much that not both windows can be fitted, the declared model has to tell.
        wider, left = with_what_is_left(wider, final, apart or declared)
    return Diagnosis(
        shots=(),
        refused=(),
        model=model,
        verdict=verdict,
        named=(*named, *gap_effects(gaps)),
        tentative=tentative,
        why_not=why_not,
        integrity=(),
        found=found,
        final=final,
        before=searched.before,
        after=searched.after,
        parameters_before=means(found.base),
        parameters_after=wider,
        sigma_before={name: one.sigma for name, one in declared.items()},
        sigma_after={name: one.sigma for name, one in apart.items()},
        torque=torque,
        moving=moving_parameters(found.base, pool),
        next_measurements=tuple(
            proposals(
                [ambiguity_of(n, final, pool) for n in named if n.confounders],
                rest.excess if torque is not None else 0.0,
                dipole=first.shot.record.quantity != "angle",
            )
        ),
        notes=(
            *notes(found, final, alike, refused, searched.dropped),
            *(own.notes if own is not None and differ else ()),
            *(searched.own.told.notes if searched.own is not None else ()),
            *two_in_place_notes(named),
            *(one.note for one in small[:1]),
            *searched.doubts,
            *undecided(exact, spanned),
            *left,
            *side_modes,
            *weight,
            *hidden_error_notes(final, verdict),
        ),
        seconds=0.0,
    )


def _prepared(
    shots: list[DiagnosisShot], model: RingDownModel, pool: Executor
) -> tuple[list[PreparedShot], list[UnfittedShot], list[DataDefect], list[DataDefect]]:
    """Shots with fits of the declared model, shots without one, defects that were left out, gaps that were filled."""
    whole = [after_clipping(s, k) for k, s in enumerate(shots)]
    flawed = data_defects([s for s, _ in whole])
    bad = {f.shot for f in flawed}
    usable = [s for k, (s, _) in enumerate(whole) if k not in bad]
    flawed += [defect for _, cut in whole for defect in cut]
    angle = shots[0].record.quantity == "angle"
    if angle:
        usable, stale = without_stale_samples(usable)
        flawed += stale
    usable, gaps = filled_angles([as_measured(s) for s in usable], pool) if angle else (usable, [])
    usable = [as_measured(s) for s in usable]  # of filled ones the noise was measured again
    prepared, refused = initial_fits(usable, model, pool)
    if prepared and not angle:
        prepared, gaps = filled_dipoles(prepared, model, pool)
    return prepared, refused, flawed, gaps


def _other_explanations(
    named: Sequence[AcceptedEffect], small: Sequence[NegligibleEffect]
) -> list[tuple[dict[str, Mean], float]]:
    """Parameters in each other model that the data allow, and its rise of chi^2."""
    fits = [(r.joint_fit, r.rise) for n in named for r in n.confounders if r.joint_fit is not None]
    fits += [(one.joint_fit, 1.0) for one in small]
    return [(means(fit), rise) for fit, rise in fits]
