"""The whole diagnosis of some shots of one specimen: from what is left over to what causes it, with proof."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation import RingDownModel
from platform_daemon.schemas import DiagnosisVerdict

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
from .findings.accepted_effects import AcceptedEffect, accepted_effects, gap_effects, passed_over
from .findings.experiment_design import discrimination
from .findings.missing_torque import MissingTorque, missing_torque
from .findings.moving_parameters import MovingParameter, moving_parameters
from .findings.neglected import Neglected, neglected
from .findings.next_measurements import Ambiguity, Proposal, proposals
from .findings.notes import notes, two_in_place_notes, undecided
from .findings.verdict import assess_diagnosis
from .regression.cross_validation import CrossValidation
from .regression.hypothesis import Hypothesis
from .regression.joint_fit import JointFit, fit_jointly
from .regression.parameters import Mean, means, widened, window_disagreement
from .regression.prediction import unpredicted
from .selection.clock_gaps import filled_angles, filled_dipoles
from .selection.confounders import gain_of
from .selection.data_integrity import DataDefect, data_defects, merged, without_gaps
from .selection.kick_search import kicks
from .selection.omnibus_test import omnibus_test
from .selection.scales import beside_scales
from .selection.stepwise import ProgressCallback, Selection, select_effects
from .selection.tone_free_noise import with_tone_free_noise
from .shots.initial_fits import UnfittedShot, initial_fits
from .shots.shot import DiagnosisShot, PreparedShot
from .shots.thread_pool import shot_pool
from .validation.further_shots import further_shots
from .validation.validated_effects import validate_effects

_NOISE = 1.1  # chi^2 per degree of freedom of a model that leaves nothing
_SURELY_LESS = 30.0  # fall of chi^2
_SEARCHED = 0.7  # of the time of a series that is too long to be searched as a whole
_HERTZ_LAW_RAD = 0.5 * math.pi


class DiagnosisError(ValueError):
    """The shots cannot be diagnosed: what was seen is in the text."""


@dataclass(frozen=True)
class Diagnosis:
    """Everything that was found out, for reports.

    tentative: effects that gain but were not accepted, and in one sentence why not.
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

    @property
    def tentative_after(self) -> tuple[AcceptedEffect, ...]:
        """Those of them that are part of the model that is called "after"."""
        keys = {c.key for c in self.final.hypothesis.effects}
        return tuple(n for n in self.tentative if n.candidate.key in keys)


def diagnose_shots(
    shots: Sequence[DiagnosisShot],
    model: RingDownModel,
    tell: ProgressCallback = lambda what, share: None,
    further: Sequence[Callable[[], DiagnosisShot | None]] = (),
) -> Diagnosis:
    """Diagnose shots of one specimen that all obey the same declared model.

    tell: called with what is being done and the share that is finished. further: shots of the same series that what
    is found is tried on, each read when it is called; None from one that cannot be used.

    Raises:
        DiagnosisError: no shot can be fitted by the declared model.
    """
    began = time.perf_counter()
    with shot_pool() as pool:
        share = _SEARCHED if further else 1.0
        found = _diagnose(list(shots), model, lambda what, done: tell(what, share * done), pool, began)
        if not further:
            return found

        def told(done: int) -> None:
            tell("shots that were not searched", share + (1.0 - share) * done / len(further))

        seen = further_shots(found.final, further, pool, told)
    said = () if seen is None else (seen.note,)
    return replace(found, notes=(*said, *found.notes), seconds=time.perf_counter() - began)


def _diagnose(
    shots: list[DiagnosisShot], model: RingDownModel, tell: ProgressCallback, pool: Executor, began: float
) -> Diagnosis:
    tell("checks of the data", 0.0)
    started, refused, flawed, gaps = _prepared(shots, model, pool)
    tell("fit of the declared model", 0.1)
    found, late = _selected(started, model, gaps, tell, pool)
    gaps = merged([*gaps, *late])
    tell("prediction of held-out data", 0.8)
    seen, before, after, dropped, passed = validate_effects(found, pool)
    final = seen.joint_fit
    base = found.base
    if final is not found.best:
        found = replace(found, omnibus_test=omnibus_test(final, pool))
    named = accepted_effects(found, seen, after, passed, pool) if final.hypothesis.effects else ()
    verdict, doubts = assess_diagnosis(found, final, named, gaps, after)
    tentative, why_not = _not_accepted(found, final, named, doubts) if verdict == "unexplained" else ((), "")
    if verdict == "unexplained":
        named = ()
    tell("parameters before and after", 0.9)
    left = found.omnibus_test
    torque = missing_torque(final, left) if verdict in ("unexplained", "partly_explained") else None
    exact, alike = means(final), [r.candidate for n in named for r in n.confounders]
    small = neglected(seen, dropped, found.trials, pool) if verdict == "explained" else []
    after_all = widened(exact, _others(final, named, small, pool))
    return Diagnosis(
        shots=tuple(shots),
        refused=tuple(refused),
        model=model,
        verdict=verdict,
        named=(*named, *gap_effects(gaps)),
        tentative=tentative,
        why_not=why_not,
        integrity=(*flawed, *gaps),
        found=found,
        final=final,
        before=before,
        after=after,
        parameters_before=means(base),
        parameters_after=after_all,
        sigma_before=window_disagreement(base, pool),
        sigma_after=window_disagreement(final, pool),
        torque=torque,
        moving=moving_parameters(base, pool),
        next_measurements=tuple(
            proposals(
                [_ambiguity(n, final, pool) for n in named if n.confounders],
                left.excess if torque is not None else 0.0,
                dipole=shots[0].record.quantity != "angle",
            )
        ),
        notes=(
            *notes(found, final, alike, refused, dropped),
            *two_in_place_notes(named),
            *(one.note for one in small[:1]),
            *doubts,
            *undecided(exact, after_all),
        ),
        seconds=time.perf_counter() - began,
    )


def _prepared(
    shots: list[DiagnosisShot], model: RingDownModel, pool: Executor
) -> tuple[list[PreparedShot], list[UnfittedShot], list[DataDefect], list[DataDefect]]:
    """Shots with fits of the declared model, those without, what is wrong with others, samples that were put back."""
    flawed = data_defects(shots)
    bad = {f.shot for f in flawed}
    usable = [s for k, s in enumerate(shots) if k not in bad]
    angle = shots[0].record.quantity == "angle"
    usable, gaps = filled_angles(usable, pool) if angle else (usable, [])
    started, refused = initial_fits(usable, model, pool)
    if not started:
        why = "; ".join(dict.fromkeys(r.reason for r in refused)) or "; ".join(f.where for f in flawed)
        raise DiagnosisError(f"no shot can be fitted by the declared model {model.name}: {why}")
    if not angle:
        started, gaps = filled_dipoles(started, model, pool)
    return started, refused, flawed, gaps


def _others(
    final: JointFit, named: Sequence[AcceptedEffect], small: Sequence[Neglected], pool: Executor
) -> list[tuple[dict[str, Mean], float]]:
    """Parameters in the models that the data allow besides, and by how much more chi^2."""
    fits = [(r.joint_fit, r.rise) for n in named for r in n.confounders if r.joint_fit is not None]
    fits += [(other, 1.0) for other in beside_scales(final, pool)]
    fits += [(one.joint_fit, 1.0) for one in small]
    return [(means(fit), rise) for fit, rise in fits]


def _not_accepted(
    found: Selection, final: JointFit, named: tuple[AcceptedEffect, ...], doubts: tuple[str, ...]
) -> tuple[tuple[AcceptedEffect, ...], str]:
    """Effects that gain although nothing is explained, and why they were not accepted."""
    if found.passed_over is not None and found.passed_over.chi2 < final.chi2:
        return passed_over(found.passed_over, found.trials), "it fits better, but does not predict what was not used"
    return named, doubts[0] if doubts else "together they explain less than half of what is missing"


def _selected(
    started: list[PreparedShot],
    model: RingDownModel,
    local: Sequence[DataDefect],
    tell: ProgressCallback,
    pool: Executor,
) -> tuple[Selection, list[DataDefect]]:
    """What is found, and losses of samples that only a model of the motion shows.

    What a model lacks looks like such losses, and they look like physics: both are tried, and what leaves less stays.
    """
    found = _effects(started, model, tell, pool)
    mended, gaps = without_gaps(started, model, pool, local)
    if gaps:
        beside = _effects(mended, model, tell, pool)
        return (beside, gaps) if _leaves_less(beside, found) else (found, [])
    best = found.best
    if not best.hypothesis.torques:
        return found, []
    known = [replace(s, state=best.full_state(k)) for k, s in enumerate(best.started)]
    mended, gaps = without_gaps(known, best.hypothesis.augmented, pool, local)
    if not gaps:
        return found, []
    beside = _effects([replace(m, state=s.state) for m, s in zip(mended, started, strict=True)], model, tell, pool)
    return (beside, gaps) if _leaves_less(beside, found) else (found, [])


def _leaves_less(one: Selection, other: Selection) -> bool:
    """Nothing but noise, and surely less, in units of this noise."""
    if one.best.chi2_per_dof > _NOISE:
        return False
    left = [sum(float(np.sum(unpredicted(s.best, k) ** 2)) for k in range(len(s.best.linear))) for s in (one, other)]
    return left[0] * (1.0 + _SURELY_LESS / one.best.dof) < left[1]


def _effects(
    started: Sequence[PreparedShot], model: RingDownModel, tell: ProgressCallback, pool: Executor
) -> Selection:
    """The declared model's joint fit, and what is missing beside it."""
    base = with_tone_free_noise(fit_jointly(started, Hypothesis(model), pool), pool)
    return select_effects(base, candidates_for(base), pool, tell)


def _ambiguity(named: AcceptedEffect, final: JointFit, pool: Executor) -> Ambiguity:
    """An effect and its look-alikes, and what further measurements would make of them."""
    effect = named.candidate
    # Of an effect with a hidden scale its likeliest value stands for all.
    others: dict[object, Candidate] = {}
    there = [t.term for t in final.hypothesis.torques]
    for c in (r.candidate for r in named.confounders):
        if c.effect is not effect.effect and (c.term is None or c.term not in there):
            others.setdefault((c.effect.id, c.detail) if c.term is None else c.term.name, c)
    alike = tuple(others.values()) or tuple(r.candidate for r in named.confounders if r.candidate.term is effect.term)

    def expected(key: str) -> list[float] | None:
        return discrimination(final, effect, alike, key, pool)

    return Ambiguity(effect, alike, named.rise, gain_of(final, effect), expected)


def candidates_for(base: JointFit) -> list[Candidate]:
    """Everything with a name that can act on such shots; additive effects are found by the search itself."""
    model, record = base.hypothesis.model, base.started[0].shot.record
    if record.quantity == "angle":
        fastest = max(2.0 * s.dynamics.w * math.sin(0.5 * abs(s.dynamics.amplitude)) for s in base.states)
        longest_s = max(float(s.time_s[-1]) for s in base.started)
        return [*pendulum_candidates(model, fastest, longest_s), *zero_drifts(longest_s), *kicks(base)]
    small = all(abs(s.dynamics.amplitude) < _HERTZ_LAW_RAD for s in base.states)
    found = [*torque_candidates(model, jewel_law=small), drift_candidate(), *stribeck_candidates(model)]
    # A weak drift too: without it others imitate one that comes to rest.
    found.append(settling_candidate(max(float(s.time_s[-1]) for s in base.started)))
    f_nat_hz = float(np.mean([s.dynamics.w for s in base.states])) / (2.0 * math.pi)
    return [*found, *receiver_candidates(record.channels, record.quantity, f_nat_hz)]
