"""What a certificate says, and when it is refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import date, datetime
from pathlib import Path
from statistics import median

from drivers.errors import InputError
from drivers.specimen import Specimen
from drivers.uncertainty import DeclaredUncertainty, Influence
from platform_daemon import __version__
from platform_daemon.core.recordings.evidence import file_digests
from platform_daemon.core.schemas.fits import FrameFit
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.core.schemas.text import same_name
from platform_daemon.features.budget.declared import declared_in
from platform_daemon.features.budget.schema import BudgetReport
from platform_daemon.features.budget.work import series_budgets
from platform_daemon.features.budget.written import budget_report
from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.known_moment import declared_specimen
from platform_daemon.features.fit.measurement import Measurement, VoltageMeasurement
from platform_daemon.features.fit.series_table import recorded_fits
from platform_daemon.features.measurand.schema import MeasurandCalibration
from platform_daemon.uncertainty.budget import Budget

from .details import CertificateDetails, Contact
from .schema import CertificateContact, CertificateReport, TraceabilityLine
from .sensor_part import reference_line, sensor_part
from .thresholds import MOST_CHI2_PER_DOF

_UNITS = {
    "temperature": "K",
    "static field": "T",
    "position": "m",
    "mounting pose": "rad",
    "phase": "rad",
    "orthogonality": "rad",
    "drift since": "1/a",
}
"""Of inputs, by how their names begin; all others are relative."""
STATED = ("f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2")
"""Parameters that a certificate states, as far as the model has them."""


def certificate_of(
    specimen: Specimen,
    measurement: Measurement,
    ask: FitRequest,
    details: CertificateDetails,
    *,
    declared: DeclaredUncertainty | None = None,
    sensor: MeasurandCalibration | None = None,
    issued: date,
    coverage: float = 0.95,
) -> CertificateReport:
    """The certificate of a specimen by one recording of several shots.

    declared: before what the recording declares.  sensor: its calibration as a sensor, None: it is certified as none.
    Raises InputError for a recording or a calibration of another specimen, a recording without receive calibration, and
    where an influence that nobody has declared dominates, or one whose effect is not known, as of a model that does not
    describe the shots, and where a certificate of an input has expired.
    """
    where = str(measurement.path)
    recording = measurement.recording if isinstance(measurement, VoltageMeasurement) else None
    if recording is None or recording.provenance is None or measurement.calibration is None:
        remedy = "give a calibrated recording of this software"
        raise InputError("nothing can be certified by this file", where=where, remedy=remedy)
    own = declared_specimen(recording)
    if own is None or same_name(own.name) != same_name(specimen.name):
        what = f"it is of {own.name!r}, not of {specimen.name!r}" if own is not None else "it names no resonator"
        raise InputError(what, where=where, remedy="give a recording of the specimen")
    part = None if sensor is None else sensor_part(sensor, specimen.name, coverage)
    found = series_budgets(measurement, ask, declared=declared, coverage=coverage)
    stated = [each for each in found.budgets if each.quantity in STATED]
    refuse_dominated(stated, where)
    fits = recorded_fits(measurement, ask) or fit_measurement(measurement, ask).frames
    misfit = misfit_of(fits, details, where)
    results = tuple(map(budget_report, stated))
    said = declared_in(recording).under(declared)
    stamps = [info.time_stamp for info in recording.frame_info if info.time_stamp]
    days = sorted(datetime.fromisoformat(stamp).date() for stamp in stamps) or [
        date.fromisoformat(recording.provenance.start_time[:10])
    ]
    calibration = measurement.calibration
    return CertificateReport(
        number=details.number,
        issued=issued.isoformat(),
        laboratory=_contact(details.laboratory),
        customer=_contact(details.customer),
        person=details.person,
        item=specimen.name,
        sample=recording.provenance.sample_name,
        variant=specimen.variant,
        method=(
            f"ring-down of the resonator after excitation, fitted with the equation of motion of the {ask.label} "
            f"bearing over the window {ask.window}; mean of {len(found.frames)} shots",
            f"platform-daemon {__version__}; recorded by {recording.provenance.software_version}",
            "uncertainty by JCGM 100:2008, coverage factor of the t distribution",
            f"receive calibration {calibration.identifier or 'without a name'} of {(calibration.date or '')[:10]}",
        ),
        measured_from=days[0].isoformat(),
        measured_to=days[-1].isoformat(),
        temperature_c=found.temperature_c,
        shots=len(found.frames),
        traceability=(*_traceability(results), *(() if sensor is None else reference_line(sensor))),
        results=results,
        sensor=part,
        cone_rad=found.cone_rad,
        valid_until=_valid_until(said, sensor, issued, where),
        accepted_misfit=misfit,
        not_contained=_not_contained(stated),
        files=(*file_digests([measurement.path]), *(() if sensor is None else sensor.files)),
    )


def refuse_dominated(results: Sequence[Budget], where: str) -> None:
    """Raises InputError if something that nobody has declared adds, at the size by which it is judged, more than all
    that is declared together, or adds what is not known."""
    found = []
    for each in results:
        for missing in each.not_declared:
            adds = missing.would_add_per_unit
            unknown = math.isnan(adds)
            if not missing.looked_for and (unknown or adds > each.u):
                found.append(f"{each.quantity}: {missing.name}" + ("" if unknown else f" adds {adds:.3g}"))
    if found:
        raise InputError(
            "no certificate: what nobody has declared dominates",
            where=where,
            why="; ".join(found),
            remedy="declare it in [uncertainty] of platform or resonator, or give --uncertainty FILE",
        )


def misfit_of(fits: Sequence[FrameFit], details: CertificateDetails, where: str) -> str | None:
    """What the certificate says of a model that leaves more than noise; None: it leaves none.

    What its error adds to the values, nobody knows: raises InputError unless the details say why it is accepted.
    """
    left = median(fit.chi2_per_dof or 0.0 for fit in fits if fit.good)
    if left <= MOST_CHI2_PER_DOF:
        return None
    why = f"χ²/dof is {left:.3g} in the middle of them, and what an error of the model adds is not known"
    if details.accepted_misfit is None:
        remedy = "`platform-daemon diagnose FILE` names what it lacks; certify a resonator that it describes, or say "
        remedy += "in the details why it is accepted: accepted_misfit"
        raise InputError("no certificate: the model does not describe the shots", where=where, why=why, remedy=remedy)
    return f"the model does not describe the shots: {why}; accepted by {details.person}: {details.accepted_misfit}"


def _contact(contact: Contact) -> CertificateContact:
    return CertificateContact(name=contact.name, city=contact.city, country=contact.country)


def _traceability(results: Sequence[BudgetReport]) -> tuple[TraceabilityLine, ...]:
    found: dict[str, TraceabilityLine] = {}
    for each in results:
        for line in (line for line in each.inputs if line.type == "B"):
            name, unit = line.name, next((u for begin, u in _UNITS.items() if line.name.startswith(begin)), "1")
            if name == "model":  # of each quantity another one
                name, unit = f"model, of {each.quantity}", definition_of(each.quantity).unit
            found[name] = TraceabilityLine(name=name, u=line.u, unit=unit, source=line.source)
    return tuple(found.values())


def _valid_until(
    said: DeclaredUncertainty, sensor: MeasurandCalibration | None, issued: date, where: str
) -> str | None:
    """The first day on which a certificate of an input expires.  Raises InputError if that is over."""
    papers = [
        each.certificate.valid_until
        for name in type(said).model_fields
        if isinstance(each := getattr(said, name), Influence) and each.certificate is not None
    ]
    if sensor is not None and sensor.reference is not None and sensor.reference.valid_until is not None:
        papers.append(date.fromisoformat(sensor.reference.valid_until))
    known = [day for day in papers if day is not None]
    if known and min(known) < issued:
        what, why = "no certificate: it would not be valid any more", f"an input's certificate expired on {min(known)}"
        remedy = "have the instrument calibrated again, declare its new certificate, and record again"
        raise InputError(what, where=where, why=why, remedy=remedy)
    return min(known).isoformat() if known else None


def _not_contained(stated: Sequence[Budget]) -> tuple[str, ...]:
    return tuple(
        f"{each.quantity}: {missing.name}: {missing.would_add_per_unit:.3g} {definition_of(each.quantity).unit}"
        for each in stated
        for missing in each.not_declared
        if not missing.looked_for
    )


def read_details(path: Path) -> CertificateDetails:
    """Of a TOML file.  Raises ConfigError."""
    from drivers.validation import validated
    from platform_daemon.core.settings import read_toml

    return validated(CertificateDetails, read_toml(path)[0], str(path))
