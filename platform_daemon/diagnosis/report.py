"""The diagnosis as its fixed report, in which what is not finite is null."""

from __future__ import annotations

import math
from collections.abc import Sequence

from scipy.stats import norm

from platform_daemon.core.schemas.fits import Covariance, FileDigest
from platform_daemon.diagnosis.diagnosis_result import Diagnosis
from platform_daemon.diagnosis.findings.accepted_effects import AcceptedEffect
from platform_daemon.diagnosis.findings.missing_torque import MissingTorque
from platform_daemon.diagnosis.findings.moving_parameters import MovingParameter as MovedParameter
from platform_daemon.diagnosis.regression.parameters import Mean
from platform_daemon.diagnosis.report_schema import (
    DataDefectReport,
    DiagnosisReport,
    EffectDetail,
    EffectStrength,
    HeldOutErrors,
    MeanParameter,
    MissingTorqueMap,
    MovingParameter,
    NamedEffect,
    NextMeasurement,
    ParameterTrace,
    RecordedSources,
    TentativeEffect,
    TriedEffect,
    UnexplainedRest,
    WindowDisagreement,
)
from platform_daemon.diagnosis.selection.significance import chance
from platform_daemon.diagnosis.selection.stepwise import CandidateTest
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.shots.torque_course import course_of
from platform_daemon.diagnosis.thresholds import THRESHOLDS


def diagnosis_report(
    found: Diagnosis,
    *,
    files: Sequence[str] | None = None,
    recordings: Sequence[FileDigest] | None = None,
    value_sources: Sequence[RecordedSources] = (),
    seconds: float | None = None,
) -> DiagnosisReport:
    """The report as it is written to JSON.

    Args:
        found: the diagnosis.
        files, recordings: names and digests of the files that were read; None if there are none.
        value_sources: where the values of these files come from, as far as it is known.
        seconds: wall time to be reported, s; None: that of the diagnosis.
    """
    return DiagnosisReport(
        verdict=found.verdict,
        effects=tuple(_effect(n, found.shots[0]) for n in found.named),
        held_out=_held_out(found),
        parameters_before=_means(found.parameters_before),
        parameters_after=_means(found.parameters_after),
        n50_d30={
            n: WindowDisagreement(before_sigma=found.sigma_before.get(n), after_sigma=found.sigma_after.get(n))
            for n in (found.sigma_before | found.sigma_after)
        },
        integrity=tuple(DataDefectReport(id=f.id, where=f.where) for f in found.integrity),
        missing_torque=None if found.torque is None else _torque(found.torque),
        next_measurements=tuple(
            NextMeasurement(what=p.measurement.what, separates=p.separates, expected_sigma=p.expected_sigma)
            for p in found.next_measurements
        ),
        seconds=found.seconds if seconds is None else seconds,
        model=found.model.name,
        scatter={n: m.scatter for n, m in found.parameters_after.items()},
        ranking=tuple(map(_tried, found.found.tried[: THRESHOLDS.findings.ranked_candidates])),
        left_over=_left_over(found),
        notes=found.notes,
        where=tuple(map(_moving, found.moving)) or None,
        tentative=_tentative(found) or None,
        model_after=model_in_words(_base_in_words(found), after_effects(found)),
        files=None if files is None else tuple(files),
        value_sources=tuple(value_sources) or None,
        recordings=None if recordings is None else tuple(recordings),
    )


def _left_over(found: Diagnosis) -> UnexplainedRest:
    """Beside the named effects; of a rigid rotor, or beside a torque's course, the excess of chi^2 over noise."""
    if found.rotor is not None:
        chi2, dof = sum(found.rotor.fit.chi2), float(sum(found.rotor.fit.dof))
    elif any(course_of(state) is not None for state in found.final.states):
        chi2, dof = found.final.chi2, found.final.dof
    else:
        return UnexplainedRest(gain=found.found.omnibus_test.excess, p_value=found.found.omnibus_test.p_value)
    return UnexplainedRest(gain=max(chi2 - dof, 0.0), p_value=float(norm.sf((chi2 - dof) / math.sqrt(2.0 * dof))))


def _base_in_words(found: Diagnosis) -> str:
    """The declared model, or that of a rotor without an error."""
    perfect = found.rotor is not None and not found.rotor.sure
    return f"{found.model.name} with five degrees of freedom" if perfect else found.model.name


def after_effects(found: Diagnosis) -> tuple[NamedEffect, ...]:
    """Effects of the final model, accepted or not."""
    named = found.named if found.verdict != "unexplained" else (*found.tentative_after, *found.named)
    return tuple(_effect(n, found.shots[0]) for n in named)


def _tentative(found: Diagnosis) -> tuple[TentativeEffect, ...]:
    return tuple(TentativeEffect(effect=_effect(n, found.shots[0]), why_not=found.why_not) for n in found.tentative)


def model_in_words(base: str, effects: Sequence[NamedEffect]) -> str:
    """thread + coulomb_friction (0.158 rad/s^2)."""
    parts = [f"{e.id} ({e.strength.value:.4g} {e.strength.unit})".replace(" 1)", ")") for e in effects]
    return " + ".join([base, *parts])


def _held_out(found: Diagnosis) -> HeldOutErrors:
    before, after = found.before.total, found.after.total
    return HeldOutErrors(
        nrmse_before=before.nrmse if before.dof else None,
        nrmse_after=after.nrmse if after.dof else None,
        chi2_per_dof_before=before.chi2_per_dof if before.dof else None,
        chi2_per_dof_after=after.chi2_per_dof if after.dof else None,
        n_shots=len(found.final.prepared),
    )


def _means(means: dict[str, Mean]) -> dict[str, MeanParameter]:
    return {n: MeanParameter(value=m.value, std=m.std) for n, m in means.items()}


def _effect(named: AcceptedEffect, shot: DiagnosisShot) -> NamedEffect:
    c = named.candidate
    # Additive effects have the unit of the record, the compression has that of the digitiser's samples.
    in_units = {"A m^2/s": shot.unit, "1/V^2": f"1/{shot.volts}^2"}
    unit = in_units.get(c.effect.unit, c.effect.unit)
    others = dict.fromkeys(r.candidate.effect.id for r in named.confounders)
    return NamedEffect(
        id=c.effect.id,
        strength=EffectStrength(value=named.strength, std=named.std, unit=unit),
        detail=_detail(named),
        p_value=chance(named.log_p),
        held_out_gain=named.held_out_gain,
        indistinguishable_from=tuple(i for i in others if i != c.effect.id),
        log10_p_value=named.log_p / math.log(10.0),
        source=c.effect.source,
        covariance=None
        if named.covariance is None
        else Covariance(parameters=named.covariance[0], matrix=tuple(map(tuple, named.covariance[1].tolist()))),
    )


def _detail(named: AcceptedEffect) -> EffectDetail:
    d, c = named.candidate.detail, named.candidate
    pairs = () if c.term is None or not c.hidden else zip(c.term.coefficients[1:], c.hidden, strict=True)
    scales = {coefficient.name: value for coefficient, value in pairs}
    fitted = dict(list(scales.items())[:1])  # what is hidden beside the first is held
    if d.tau_s is not None:
        fitted["tau_s"] = d.tau_s
    return EffectDetail(
        axis=d.axis,
        frequency_hz=d.frequency_hz,
        tau_s=d.tau_s,
        sample=d.sample,
        source=d.start,
        target=d.end,
        std=None if named.log_scale_std is None else {k: abs(v) * named.log_scale_std for k, v in fitted.items()},
        **scales,
        **c.held,
    )


def _tried(tried: CandidateTest) -> TriedEffect:
    c = tried.candidates[0]
    return TriedEffect(
        id=c.effect.id,
        axis=c.detail.axis,
        frequency_hz=c.detail.frequency_hz,
        tau_s=c.detail.tau_s,
        gain=tried.gain,
        p_value=chance(tried.log_p),
        sign_allowed=tried.allowed,
    )


def _moving(moved: MovedParameter) -> MovingParameter:
    return MovingParameter(
        name=moved.name,
        p_value=chance(moved.log_p),
        log10_p_value=moved.log_p / math.log(10.0),
        share=moved.share,
        follows=moved.fit.follows,
        rises=moved.fit.rises,
        alike=moved.alike,
        traces=tuple(
            ParameterTrace(
                time_s=t.time_s.tolist(),
                amplitude_rad=t.amplitude.tolist(),
                peak_speed_rad_per_s=t.peak_speed.tolist(),
                value=t.value.tolist(),
                std=t.std.tolist(),
            )
            for t in moved.traces
        ),
    )


def _torque(torque: MissingTorque) -> MissingTorqueMap:
    return MissingTorqueMap(
        phi=torque.phi.tolist(),
        phi_dot=torque.phi_dot.tolist(),
        value=torque.value.tolist(),
        std=torque.std.tolist(),
        gain=torque.gain,
    )
