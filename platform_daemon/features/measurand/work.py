"""Calibrating a resonator as a sensor, and reading it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from drivers.errors import InputError
from drivers.specimen import Measurand, Specimen
from platform_daemon import __version__
from platform_daemon.core.recordings.evidence import file_digests
from platform_daemon.features.budget.influences import certified_source
from platform_daemon.uncertainty.calibration_curve import (
    CalibratedCurve,
    Points,
    Trend,
    fit_curve,
    trend_in,
    turning_points,
    with_lag,
)
from platform_daemon.uncertainty.cross_validation import cross_validated
from platform_daemon.uncertainty.curves import Curve, Polynomial

from .plausible import refuse_other_scale, refuse_other_unit, refuse_other_zone, refuse_vague
from .reference_file import Reference
from .schema import CrossValidationReport, MeasurandCalibration, ReferenceU, ResidualTest
from .sensor import SECONDS_PER_DAY, named_curve, stamp
from .shots import Shots
from .thresholds import COVERED, SIGNIFICANT


def key_of(specimen: str) -> str:
    """Name of a file for a specimen: letters, digits and hyphens; names that differ in signs only share it."""
    return re.sub(r"[^A-Za-z0-9]+", "-", specimen).strip("-")[:60] or "specimen"


def declared_measurand(specimen: Specimen, where: str) -> Measurand:
    """What it is a sensor for.  Raises InputError if it says nothing."""
    if specimen.measurand is None:
        remedy = "declare it in the resonator's file: [measurand] with name and unit"
        raise InputError("the specimen is declared as no sensor", where=where, remedy=remedy)
    return specimen.measurand


def calibrated(
    name: str,
    measurand: Measurand,
    shots: Shots,
    reference: Reference,
    version: int,
    files: Sequence[Path] = (),
    before: MeasurandCalibration | None = None,
) -> MeasurandCalibration:
    """The calibration of a specimen by readings of a reference.

    before: an earlier one, which shows whether the readings are in the same unit; None: there is none.

    Raises InputError for too few pairs, a temperature that is to be corrected for and was not measured, a lag longer
    than declared, a certificate of the reference that was not valid then, readings that are of another unit or zone by
    what they show, and a curve that turns within its range, so that two values have the same frequency.
    """
    longest = measurand.longest_lag_s
    usable = reference.covered(shots.times_s) & reference.covered(shots.times_s + longest)
    if not usable.any():
        raise _no_pair(name, shots, reference)
    if before is not None:
        there = shots.f_hz[usable], shots.celsius[usable], reference.at(shots.times_s[usable])[0]
        refuse_other_scale(before, *there, measurand, name)
    curve, found, points, lag, lag_std = _fitted(name, measurand, shots, reference, usable)
    warm = measurand.corrected_for == "temperature"
    times, celsius = shots.times_s[usable], shots.celsius[usable]
    rising = np.sign(np.gradient(reference.at(times, lag or 0.0)[0], times))
    days = (times - times.mean()) / SECONDS_PER_DAY
    measured = bool(np.isfinite(celsius).all())
    changed = not warm and measured and float(np.ptp(celsius)) > 0.0
    by_temperature = _test(trend_in(found, points, celsius - celsius.mean())) if changed else None
    checked = _cross_validation(curve, points)
    middle = np.array([fmean(found.x_range)])
    polynomial = curve if isinstance(curve, Polynomial) else None
    return MeasurandCalibration(
        specimen=name,
        key=key_of(name),
        version=version,
        name=measurand.name,
        unit=measurand.unit,
        model=measurand.model,
        degree=0 if polynomial is None else polynomial.degree,
        centre=0.0 if polynomial is None else polynomial.centre,
        scale=1.0 if polynomial is None else polynomial.scale,
        parameters=dict(zip((*curve.names, "per_k")[: len(found.parameters)], found.parameters.tolist(), strict=True)),
        covariance=tuple(map(tuple, found.covariance.tolist())),
        valid_from=found.x_range[0],
        valid_to=found.x_range[1],
        temperature_c=found.second_at,
        temperature_from_c=float(celsius.min()) if measured else None,
        temperature_to_c=float(celsius.max()) if measured else None,
        scatter_hz=found.scatter,
        dof=found.dof,
        chi2_per_dof=found.chi2_per_dof,
        lag_s=lag,
        lag_std_s=lag_std,
        hysteresis_hz=_test(trend_in(found, points, rising)),
        drift_hz_per_day=_test(trend_in(found, points, days)),
        by_temperature_hz_per_k=by_temperature,
        cross_validation=checked,
        reference=_reference_u(measurand, float(times[-1])),
        resolution=found.scatter / abs(float(found.slope(middle)[0])),
        pairs=int(usable.sum()),
        dropped=int((~usable).sum()) + len(shots.refused),
        began=stamp(times[0]),
        ended=stamp(times[-1]),
        software_version=__version__,
        files=file_digests(files),
        notes=_notes(measurand, by_temperature, checked),
    )


def _fitted(
    name: str, measurand: Measurand, shots: Shots, reference: Reference, usable: NDArray[np.bool_]
) -> tuple[Curve, CalibratedCurve, Points, float | None, float | None]:
    """The form, what is fitted, its pairs, the lag and its standard deviation.  Raises InputError."""
    warm = measurand.corrected_for == "temperature"
    if warm and not np.isfinite(shots.celsius[usable]).all():
        remedy = "record with a thermometer, or leave corrected_for out"
        raise InputError("the temperature was not measured", where=name, remedy=remedy)
    places = np.flatnonzero(usable)

    def pairs(by: Reference, at: NDArray[np.intp], lag_s: float = 0.0) -> Points:
        x, u_x = by.at(shots.times_s[at], lag_s)
        return Points(x, u_x, shots.f_hz[at], shots.std_hz[at], shots.celsius[at] if warm else None)

    first = pairs(reference, places)
    refuse_vague(measurand, first, name)
    refuse_other_unit(measurand, first.x, shots.celsius[places], name)
    curve = _curve(measurand, first)
    lag = lag_std = None
    if measurand.longest_lag_s > 0.0:
        by_lag = partial(pairs, reference, places)
        found, points, lag, lag_std = with_lag(curve, by_lag, measurand.longest_lag_s)
    else:
        found, points = fit_curve(curve, first), first
    timed = np.where(np.isfinite(shots.celsius), shots.times_s, np.nan) if warm else shots.times_s
    refuse_other_zone(curve, found, points, timed, reference, pairs, name)
    _refuse_turning(found, name, measurand)
    return curve, found, points, lag, lag_std


def _cross_validation(curve: Curve, points: Points) -> CrossValidationReport:
    checked = cross_validated(curve, points)
    return CrossValidationReport(rms=checked.rms, covered=checked.covered, readings=checked.readings)


def _no_pair(name: str, shots: Shots, reference: Reference) -> InputError:
    why = f"the shots were made from {stamp(shots.times_s.min())} to {stamp(shots.times_s.max())}"
    why += f", the reference was read from {stamp(reference.times_s[0])} to {stamp(reference.times_s[-1])}"
    remedy = "check zone and clock of the reference"
    return InputError("no shot has a reading of the reference", where=name, why=why, remedy=remedy)


def _refuse_turning(found: CalibratedCurve, name: str, measurand: Measurand) -> None:
    if turns := turning_points(found):
        at = ", ".join(f"{each:.6g} {measurand.unit}" for each in turns)
        what = "two values have the same frequency: the inverse is ambiguous"
        remedy = "calibrate on one side of it only, or choose a lower degree"
        raise InputError(what, where=f"{name}, {measurand.name}", why=f"f turns at {at}", remedy=remedy)


def _notes(
    measurand: Measurand, by_temperature: ResidualTest | None, checked: CrossValidationReport
) -> tuple[str, ...]:
    notes = []
    if measurand.reference is None:
        notes.append("what the readings of the reference have in common is not declared: U does not contain it")
    if by_temperature is not None and by_temperature.significant:
        notes.append("f changes with the temperature, which the measurand is not corrected for: see corrected_for")
    if checked.covered < COVERED:
        notes.append(
            f"U covers {checked.covered:.0%} of readings that the calibration was not made of, and should cover 95 %: "
            "record more, or choose a model with fewer parameters"
        )
    return tuple(notes)


def _curve(measurand: Measurand, points: Points) -> Curve:
    if measurand.model == "polynomial":
        low, high = float(points.x.min()), float(points.x.max())
        return Polynomial(measurand.degree, 0.5 * (low + high), 0.5 * (high - low) or 1.0)
    return named_curve(measurand.model)


def _reference_u(measurand: Measurand, last_s: float) -> ReferenceU | None:
    """Raises InputError for a certificate that was not valid on the day of the last shot."""
    if (known := measurand.reference) is None:
        return None
    source = certified_source(known, "[measurand] reference", datetime.fromtimestamp(last_s, UTC).date())
    u, distribution = known.standard_uncertainty, known.distribution
    day = known.certificate.valid_until if known.certificate is not None else None
    until = None if day is None else day.isoformat()
    return ReferenceU(u=u, distribution=distribution, type=known.kind, dof=known.dof, valid_until=until, source=source)


def _test(found: Trend) -> ResidualTest:
    return ResidualTest(
        value=found.value, u=found.u, probability=found.probability, significant=found.probability < SIGNIFICANT
    )
