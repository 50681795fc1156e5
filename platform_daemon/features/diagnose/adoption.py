"""From a diagnosis to the model that is to be adopted, or the reason why it is not."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from drivers.calibration import ReceiverEffect
from drivers.errors import InputError
from platform_daemon import __version__
from platform_daemon.core.recordings.evidence import file_digests
from platform_daemon.core.schemas.fits import FileDigest
from platform_daemon.diagnosis.effects.fluctuation import FREQUENCY_FLUCTUATION, FRICTION_FLUCTUATION
from platform_daemon.diagnosis.report_schema import DiagnosisReport, NamedEffect
from platform_daemon.estimation.calibration.receiver_correction import CORRECTABLE
from platform_daemon.estimation.physics.torques import TERMS
from platform_daemon.estimation.rotor_fit.parameters import KNOWN_WITH_A_DEFECT, NEEDED_WITH_A_DEFECT, Defect
from platform_daemon.features.models.adopted_model import AdoptedModel
from platform_daemon.features.models.library import Library, check_name
from platform_daemon.features.models.resolve import resolve
from platform_daemon.features.models.schema import AdoptedRotorRecord, AdoptedTermRecord, AdoptionEvidence

_ROTORS: dict[str, Defect] = {
    "stator_tilt": "stator_tilt_rad",
    "rotor_tilt": "bearing_tilt_rad",
    "jewel_tilt": "bearing_tilt_rad",
    "lateral_displacement": "lateral_displacement_m",
}
_ADOPTABLE = ("explained", "partly_explained")
_NOT_A_MODEL = {
    "mains_interference": "keep mains loops away from the coils; fits take hum out of each record by themselves",
    "spectral_line": "find and remove its source; its phase is another one in every shot",
    "side_mode": "excite along another axis or with a lower field, or shorten the window",
    "switch_transient": "lengthen the switch window, or start the fit later",
    "zero_drift": "let the encoder warm up, or mount the camera firmly; fits take a slow drift out of each record",
    "quadratic_nonlinearity": "calibrate the scale of the angle, correct the samples and diagnose again",
    "cubic_nonlinearity": "calibrate the scale of the angle, correct the samples and diagnose again",
    "kick": "keep the stand from being touched; a kick belongs to one recording only",
    "friction_fluctuation": "clean the contact, or average over more shots: errors of their means contain its scatter",
    "frequency_fluctuation": "hold the contact in its place, or average over more shots: errors of their means contain "
    "its scatter",
    "clock_gap": "repair the data acquisition; samples that are missing belong to no model",
}


class AdoptionRefused(InputError):
    """The diagnosis does not carry the model that was requested."""

    title = "Adoption refused"


def model_from_diagnosis(
    found: DiagnosisReport,
    name: str,
    by: str,
    library: Library,
    recordings: Sequence[FileDigest] | None = None,
    *,
    effects: Collection[str] = (),
    free: Collection[str] = (),
    force: str = "",
) -> AdoptedModel:
    """The model that a diagnosis carries, to be added to the library.

    Args:
        recordings: digests of the data that were diagnosed; None: of those that the diagnosis names.
        effects: ids to adopt; empty: all.
        free: ids of torque effects whose strength fits estimate again.
        force: why a diagnosis is adopted that did not explain its data.

    Raises:
        AdoptionRefused: with reason and remedy. InputError: a number is missing in it, or the name is no good.
    """
    check_name(name)
    chosen = _chosen(found, effects, free, force)
    base = resolve(found.model, library)
    before = base if isinstance(base, AdoptedModel) else None
    values = {n: v.value for n, v in found.parameters_after.items()}
    rotor = next((_rotor(e, found) for e in chosen if e.id in _ROTORS), None)
    if before is not None and (before.rotor or (rotor and before.terms)):
        why = "a rotor of five degrees of freedom takes neither torque terms nor a second error beside its own"
        remedy = f"diagnose on {before.base}, without the adopted model"
        raise AdoptionRefused("the rotor takes nothing beside its error", where=before.label, why=why, remedy=remedy)
    return AdoptedModel(
        name=name,
        version=0,
        base=found.model if before is None else before.base,
        terms=(*(before.terms if before else ()), *(_term(e, values, free) for e in chosen if e.id in TERMS)),
        receiver=(*(before.receiver if before else ()), *(_receiver(e, values) for e in chosen if e.id in CORRECTABLE)),
        rotor=rotor,
        evidence=AdoptionEvidence(
            adopted_by=by,
            adopted_at=datetime.now(UTC).isoformat(timespec="seconds"),
            software_version=__version__,
            started_from=found.model,
            forced=force or None,
            recordings=_data(found) if recordings is None else tuple(recordings),
            diagnosis=found,
        ),
    )


def _data(found: DiagnosisReport) -> tuple[FileDigest, ...]:
    """What a diagnosis rests on.  Raises InputError if it does not say."""
    said = found.recordings or file_digests(map(Path, found.files or ()))
    if not said:
        remedy = "name the recordings that were diagnosed (--recording)"
        raise InputError("does not say which data it rests on", where="diagnosis", remedy=remedy)
    return said


def _chosen(found: DiagnosisReport, wanted: Collection[str], free: Collection[str], force: str) -> list[NamedEffect]:
    """The effects to adopt.  Raises AdoptionRefused."""
    named = [e.id for e in found.effects]
    if not named:
        why = f"its verdict is {found.verdict}: no effect has a name"
        raise AdoptionRefused("there is nothing to adopt", where="effects", why=why, remedy=_MEASURE_MORE)
    if found.verdict not in _ADOPTABLE and not force:
        remedy = f"{_MEASURE_MORE}, or force it with a reason, which is kept as evidence"
        raise AdoptionRefused(
            "the diagnosis does not explain its data", where="verdict", why=found.verdict, remedy=remedy
        )
    missing = [i for i in (*wanted, *free) if i not in named]
    if missing:
        remedy = f"it names {', '.join(named)}"
        raise AdoptionRefused(f"the diagnosis does not name {missing[0]}", where="effects", remedy=remedy)
    chosen = [e for e in found.effects if not wanted or e.id in wanted]
    for e in chosen:
        if not _adoptable(e.id):
            _refuse(e, [i for i in named if _adoptable(i)])
    bound = [i for i in free if i not in TERMS]
    if bound:
        why = "only the strength of a torque can be free: a fit absorbs a receiver's in m_r, R or f_nat"
        if bound[0] in _ROTORS:
            why = "fits hold a manufacturing error, with the distance of the magnets and the side damping"
        raise AdoptionRefused(f"{bound[0]} cannot be free", where="free", why=why, remedy="leave it held")
    return chosen


def _adoptable(effect: str) -> bool:
    return effect in TERMS or effect in CORRECTABLE or effect in _ROTORS


def _rotor(effect: NamedEffect, found: DiagnosisReport) -> AdoptedRotorRecord:
    """A manufacturing error, with what else belongs to the specimen.  Raises InputError for a missing number."""
    ratio: dict[str, float] = {}
    for name in ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2"):
        if name in found.parameters_after and name in found.parameters_before:
            before = {n: v.value for n, v in found.parameters_before.items()}
            after = {n: v.value for n, v in found.parameters_after.items()}
            ratio[name] = _parameter(after, name) / _parameter(before, name)
    return AdoptedRotorRecord(
        id=effect.id,
        parameter=_ROTORS[effect.id],
        strength=_strength(effect),
        std=effect.strength.std,
        held={
            name: _number(effect, name)
            for name in KNOWN_WITH_A_DEFECT
            if name in NEEDED_WITH_A_DEFECT or name in effect.detail.hidden_scales()
        },
        ratio=ratio,
        covariance=effect.covariance,
    )


_MEASURE_MORE = "measure what the diagnosis proposes next, and diagnose again"


def _refuse(effect: NamedEffect, others: list[str]) -> None:
    why = "it belongs to the data of one measurement, not to the resonator or the receiver"
    if effect.id in ("quadratic_nonlinearity", "cubic_nonlinearity"):
        why = "it belongs to the sensor of the angle, whose scale no model corrects"
    if effect.id in (FRICTION_FLUCTUATION.id, FREQUENCY_FLUCTUATION.id):
        why = "its course is another one in every shot, which no model can hold"
    remedy = _NOT_A_MODEL.get(effect.id, "treat its cause")
    if others:
        remedy += f"; or adopt the others by name: {', '.join(dict.fromkeys(others))}"
    raise AdoptionRefused(f"{effect.id} cannot be adopted", where="effects", why=why, remedy=remedy)


def _term(effect: NamedEffect, values: Mapping[str, float | None], free: Collection[str]) -> AdoptedTermRecord:
    """A torque effect with its strength in the unit of the term's coefficient."""
    name = _term_name(effect)
    first, *hidden = TERMS[name].coefficients
    scale = _scale(name, values)
    std = effect.strength.std
    strengths = {first.name: _strength(effect) * scale, **{c.name: _number(effect, c.name) for c in hidden}}
    errors = {first.name: None if std is None else std * abs(scale), **{c.name: None for c in hidden}}
    return AdoptedTermRecord(term=name, values=strengths, std=errors, free=effect.id in free)


def _term_name(effect: NamedEffect) -> str:
    """The term of an effect with two forms: a jewel's friction or a pendulum's, a drift that continues or settles."""
    if effect.id == "stribeck_friction" and effect.strength.unit == "rad/s^2":
        return "stribeck_coulomb_friction"
    settles = effect.id == "frequency_drift" and effect.detail.tau_s is not None
    return "frequency_settling" if settles else effect.id


def _scale(effect: str, values: Mapping[str, float | None]) -> float:
    """Coefficient per published strength: a drift is published in Hz/s, Stribeck friction as a share."""
    if effect in ("frequency_drift", "frequency_settling"):
        return 1.0 / _parameter(values, "f_nat_hz")
    return _parameter(values, "tf_over_i_rad_per_s2") if effect == "stribeck_friction" else 1.0


def _receiver(effect: NamedEffect, values: Mapping[str, float | None]) -> ReceiverEffect:
    detail = effect.detail
    even, fundamental_hz = None, None
    if detail.frequency_hz is not None:
        fundamental_hz = _parameter(values, "f_nat_hz")
        even = round(detail.frequency_hz / fundamental_hz) % 2 == 0
    places = {"axis": detail.axis, "source": detail.source, "target": detail.target}
    for key, value in places.items():
        if value not in (None, "x", "y", "z") or (effect.id == "crosstalk" and key != "axis" and value is None):
            raise InputError(
                f"{value!r} is no channel", where=f"diagnosis: {effect.id}: {key}", remedy="give x, y or z"
            )
    return ReceiverEffect(effect.id, _strength(effect), even=even, fundamental_hz=fundamental_hz, **places)


def _parameter(values: Mapping[str, float | None], name: str) -> float:
    return _there(values.get(name) or None, f"parameters_after: {name}")


def _strength(effect: NamedEffect) -> float:
    return _there(effect.strength.value, f"{effect.id}: strength")


def _number(effect: NamedEffect, name: str) -> float:
    return _there(effect.detail.hidden_scales().get(name), f"{effect.id}: detail.{name}")


def _there(value: float | None, where: str) -> float:
    """A number of the diagnosis.  Raises InputError if it has none there."""
    if value is None:
        raise InputError("is missing", where=f"diagnosis: {where}", remedy="diagnose again")
    return value
