"""What a rotor of five degrees of freedom has found, as a finding like any other: effect, scores, notes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.cross_validation import CrossValidation, HeldOutScore
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.score_test import score_table
from platform_daemon.diagnosis.report_schema import DiagnosisVerdict
from platform_daemon.diagnosis.rigid_body.found_error import ManufacturingError
from platform_daemon.diagnosis.rigid_body.plane_test import PlaneTest
from platform_daemon.diagnosis.selection.confounders import Confounder
from platform_daemon.diagnosis.selection.omnibus_test import omnibus_test
from platform_daemon.diagnosis.selection.significance import log_chance
from platform_daemon.diagnosis.selection.stepwise import Selection
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.rotor import LostRotorError, NoRestError
from platform_daemon.estimation.rotor_fit.parameters import DEFECTS

from .accepted_effects import AcceptedEffect
from .next_measurements import Proposal

_MODEL_ERROR = (
    "that is {:.2g} standard deviations more than noise: friction or damping of the specimen follow another law; "
    "errors are widened by what is left, and the numbers may be off by more"
)
_POOR_PREDICTION = (
    "the ends of shots are predicted to chi2/dof {:.3g} only: losses, f_nat and the size may be those of a valley "
    "beside the right one; errors are widened by that, and the numbers may be off by more"
)
_PULL_ONLY = "T_f/I after is that of the magnets' pull alone; the rotor's weight is in the fit beside it"
_WORTH_SIGMA = THRESHOLDS.rigid_body.worth_sigma


def unsearched(base: JointFit, pool: Executor) -> Selection:
    """The declared model, beside which no effect of one angle was tried."""
    rest = omnibus_test(base, pool)
    return Selection(
        base=base,
        best=base,
        score_table=score_table(base, [], pool),
        omnibus_test=rest,
        before=rest,
        tried=(),
        trials=float(len(DEFECTS)),
        score_table_of=lambda at: score_table(at, [], pool),
    )


def rotor_scores(rotor: ManufacturingError, left: Sequence[float]) -> CrossValidation:
    """The ends of the shots, predicted from their beginnings; left: as `chi2_beside_one_angle` has it."""
    h = rotor.held_out
    rows = zip(h.chi2, h.dof, h.squares, h.energy, left, strict=True)
    return CrossValidation(tuple(HeldOutScore(chi2=c, dof=d, squares=s, energy=e, whole=w) for c, d, s, e, w in rows))


def chi2_beside_one_angle(rotor: ManufacturingError, fit: JointFit) -> list[float]:
    """chi^2 of what a rotor leaves of each shot, by the instants and the noise by which a fit of one angle is judged.

    Infinite for a motion that cannot be followed to the end of its record.
    """
    left = []
    for prepared, shot, values in zip(fit.prepared, rotor.fit.shots, rotor.fit.values, strict=True):
        record, known = prepared.shot.record, prepared.shot.rotor
        assert known is not None
        seen = np.array(record.samples)
        # A rotor's shot may be decimated, and ends where the swing has become small.
        whole = replace(shot, drive=known.drive_from(record.valid_from * record.dt_s))
        count = record.end - record.valid_from
        try:
            seen[:, record.valid_from : record.end] -= whole.rotor(values).dm_dt(count, record.sampling_rate_hz)[0]
        except (LostRotorError, NoRestError):
            left.append(math.inf)
            continue
        rest = prepared.at_instants(seen)
        left.append(float(np.sum(prepared.white(rest - rest.mean(axis=1, keepdims=True)) ** 2)))
    return left


def rotor_effect(rotor: ManufacturingError, left: Sequence[float], held_out_gain: float) -> AcceptedEffect:
    """The named manufacturing error with its evidence; left: as `chi2_beside_one_angle` has it."""
    gain = (rotor.before_chi2 - sum(left)) / max(1.0, rotor.fit.chi2_per_dof)
    return AcceptedEffect(
        candidate=Candidate(rotor.effect, held=rotor.held),
        strength=rotor.strength,
        std=rotor.std,
        log_p=log_chance(gain, 1, float(len(DEFECTS))),
        held_out_gain=held_out_gain,
        confounders=tuple(
            Confounder(candidate=Candidate(a.effect), rise=a.rise, gain=gain)
            for a in rotor.alike
            if a.effect is not rotor.effect
        ),
        covariance=rotor.covariance,
    )


def leaves_noise(rotor: ManufacturingError) -> bool:
    """What the rotor leaves over is noise."""
    return rotor.fit.chi2_per_dof < THRESHOLDS.regression.noise_chi2_per_dof


def has_model_error(rotor: ManufacturingError) -> bool:
    """What it leaves is small, and yet surely more than noise."""
    return rotor.excess_sigma > THRESHOLDS.rigid_body.doubtful_sigma


def prediction_note(rotor: ManufacturingError) -> tuple[str, ...]:
    """Where it does not predict the ends of shots, and a law that it lacks is not the cause."""
    known = rotor.predicts or has_model_error(rotor)
    return () if known else (_POOR_PREDICTION.format(rotor.held_out.chi2_per_dof),)


def may_be_imitated(best: JointFit) -> bool:
    """Whether torques on one angle, of which there are some, may be the manufacturing error of a jewel's rotor.

    Not where strengths that differ from shot to shot may still leave less.
    """
    noise = best.chi2_per_dof < THRESHOLDS.regression.noise_chi2_per_dof
    some = any(c.term is not None for c in best.hypothesis.effects)
    return some and (few_jewels(best) or (noise and _bearings(best) == {"jewel"}))


def few_jewels(fit: JointFit) -> bool:
    """All shots are of jewels, too few for strengths that differ from shot to shot."""
    return _bearings(fit) == {"jewel"} and len(fit.prepared) < THRESHOLDS.validation.fewest_own_strengths


def _bearings(fit: JointFit) -> set[str | None]:
    """Of the shots; None: of one whose resonator is not known."""
    return {None if s.shot.rotor is None else s.shot.rotor.geometry.bearing for s in fit.prepared}


def may_be_a_rotor(base: JointFit, verdict: DiagnosisVerdict, named: Sequence[AcceptedEffect]) -> bool:
    """Whether a manufacturing error is tried although the motion stays in its plane as far as the noise shows.

    A jewel's rotor rolls, and what leaves the plane drowns in the noise; the main mode and its losses show the error
    all the same, and torques on one angle can imitate it.
    """
    bearings = _bearings(base)
    if verdict == "nothing_missing" or None in bearings:
        return False
    return verdict != "explained" or ("jewel" in bearings and any(n.candidate.term is not None for n in named))


def leaves_less(rotor: ManufacturingError, final: JointFit, verdict: DiagnosisVerdict) -> bool:
    """The rotor leaves only noise, and less than the effects of one angle, by the same instants and noise.

    Effects that explain all yield only to a rotor that is told apart from them.  Effects that do not must be told apart
    from a rotor with an error, since they follow the noise at the few instants by which both are judged, and be far
    better than one without: it is what was declared, and they may only imitate its side modes.
    """
    if not leaves_noise(rotor) or (verdict == "explained" and not rotor.predicts):
        return False
    apart = THRESHOLDS.selection.told_apart_chi2
    worth = -apart if rotor.sure else -THRESHOLDS.rigid_body.perfect_rotor_chi2
    if verdict == "explained":
        worth = apart
    return sum(chi2_beside_one_angle(rotor, final)) + worth < final.chi2


def perfect_rotor_note(rotor: ManufacturingError) -> str:
    """What explains shots of a rotor without a manufacturing error."""
    fit = rotor.fit
    return (
        f"a rotor of five degrees of freedom without a manufacturing error leaves chi2/dof {fit.chi2_per_dof:.4g} over "
        f"{fit.window_s:.3g} s ({rotor.in_words}, which may be none): its main axis leans, or its swing feeds the side "
        "modes. One angle leaves more, and effects on it would only imitate that; the parameters after are the rotor's"
    )


def rotor_notes(rotor: ManufacturingError, parting: Sequence[Proposal], *, searched: bool) -> tuple[str, ...]:
    """What it is, in words; parting: what would part it from its look-alikes; searched: effects of one angle were."""
    alike = "".join(f", or {a.in_words}" for a in rotor.alike)
    fit = rotor.fit
    free = fit.shots[0].start == "free"
    begun = "from a free state at the start of each shot" if free else "from rest through the recorded drive"
    return (
        f"{rotor.in_words}{alike}: a rotor of five degrees of freedom, {begun}, leaves "
        f"chi2/dof {fit.chi2_per_dof:.4g} over {fit.window_s:.3g} s",
        *(_MODEL_ERROR.format(rotor.excess_sigma) for _ in range(has_model_error(rotor))),
        *prediction_note(rotor),
        "effects of one angle leave more" if searched else "effects of one angle were not searched beside it",
        *(_PULL_ONLY for _ in range(fit.shots[0].geometry.bearing == "jewel")),
        *(_not_parted(rotor, parting[0]) if parting and parting[0].expected_sigma < _WORTH_SIGMA else ()),
    )


def _not_parted(rotor: ManufacturingError, best: Proposal) -> tuple[str, ...]:
    ids = dict.fromkeys((rotor.effect.id, *(a.effect.id for a in rotor.alike)))
    what = f"part {' and '.join(ids)}" if len(ids) > 1 else f"tell the sign of {rotor.effect.id}"
    return (
        f"no measurement that is known here would {what}: at best {best.expected_sigma:.2g} standard deviations "
        f"({best.measurement.what})",
    )


def worth_measuring(parting: Sequence[Proposal]) -> tuple[Proposal, ...]:
    """Those that would part look-alikes by a standard deviation or more."""
    return tuple(p for p in parting if p.expected_sigma >= _WORTH_SIGMA)


def plane_notes(plane: PlaneTest | None, shots: Sequence[DiagnosisShot]) -> tuple[str, ...]:
    """What the plane test says, if the motion leaves its plane."""
    if plane is None or not plane.leaves:
        return ()
    low, high = (f"{100.0 * end(plane.share):.2g}" for end in (min, max))
    size = low if low == high else f"{low} to {high}"
    seen, count = len(plane.share), len(plane.shots)
    where = (
        "every shot"
        if seen == count
        else f"{seen} of {count} shots (noise or a smaller swing may hide it in the others)"
    )
    text = (
        f"the motion leaves its plane in {where}: along the main axis stands {size} % of the signal, "
        "which one angle cannot hold"
    )
    known = all(s.rotor is not None for s in shots)
    unsought = "; its cause is sought only where the bearing, thread or jewel, and a calibration are known"
    return (text if known else f"{text}{unsought}",)


def hidden_error_notes(final: JointFit, verdict: DiagnosisVerdict) -> tuple[str, ...]:
    """What a jewel's f_nat is, where nothing is missing: a small error of its rotor leaves only noise to one angle."""
    if verdict != "nothing_missing" or _bearings(final) != {"jewel"}:
        return ()
    f_nat_hz = float(np.mean([state.dynamics.w for state in final.states])) / (2.0 * math.pi)
    tilt_rad = THRESHOLDS.rigid_body.hidden_rad
    above_hz = THRESHOLDS.rigid_body.jewel_softening * tilt_rad**2 * f_nat_hz
    return (
        f"f_nat is that of the main mode: a stator tilted by up to {math.degrees(tilt_rad):.1f} deg, or a jewel or a "
        "displacement that acts like it, left only noise in simulated shots at a third of the threshold, and would put "
        f"the magnets' own f_nat up to {above_hz:.2g} Hz above it",
    )


def assumed_notes(shots: Sequence[DiagnosisShot]) -> tuple[str, ...]:
    """What a rotor takes for known that the recordings do not tell."""
    return tuple(dict.fromkeys(said for s in shots if s.rotor is not None for said in s.rotor.assumed))
