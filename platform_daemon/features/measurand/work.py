"""Calibrating a resonator as a sensor, and reading it."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from drivers.entry_points import load
from drivers.errors import InputError
from drivers.specimen import Measurand, Specimen
from platform_daemon import __version__
from platform_daemon.features.budget.written import budget_report
from platform_daemon.features.diagnose.evidence import file_digests
from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.measurement import Measurement, VoltageMeasurement
from platform_daemon.features.fit.series_table import recorded_fits
from platform_daemon.uncertainty.budget import Budget
from platform_daemon.uncertainty.calibration_curve import (
    CalibratedCurve,
    Curve,
    Dipole,
    Points,
    Polynomial,
    Trend,
    cross_validated,
    fit_curve,
    trend_in,
    turning_points,
    with_lag,
)
from platform_daemon.uncertainty.inputs import InputQuantity

from .reference_file import Reference
from .schema import (
    CrossValidationReport,
    MeasurandCalibration,
    MeasurandReading,
    MeasurandReport,
    ReferenceU,
    ResidualTest,
    UnreadShot,
)

Array = NDArray[np.float64]
MODELS = "platform_daemon.measurand_models"  # entry points: functions (x, f) -> Curve of the uncertainty package
SIGNIFICANT = 0.01
"""Chance below which hysteresis, drift and an uncorrected temperature are lines of the budgets: of a hundred
calibrations without them one gets such a line."""
SECONDS_PER_DAY = 86400.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Shots:
    """Good fits of shots with a time, in its order.

    Attributes:
        frames: (n) numbers; times_s: (n,) s since 1970; f_hz, std_hz: (n,) natural frequency and what noise leaves.
        celsius: (n,) temperature, NaN: not measured; refused: frames without a fit, with the reason.
    """

    frames: tuple[int, ...]
    times_s: Array
    f_hz: Array
    std_hz: Array
    celsius: Array
    refused: tuple[UnreadShot, ...]


def shots_of(measurement: Measurement, ask: FitRequest) -> Shots:
    """The natural frequencies of a recording.  Raises InputError for one without times of its shots."""
    fits = recorded_fits(measurement, ask) or fit_measurement(measurement, ask).frames
    rows, refused = [], []
    for fit in fits:
        if not fit.good:
            refused.append(UnreadShot(frame=fit.frame, reason=fit.reason or ""))
            continue
        found = fit.parameters["f_nat_hz"]
        celsius = measurement.conditions(fit.frame).temperature_c
        rows.append((fit.frame, _time_of(measurement, fit.frame), found.value, found.std or 0.0, celsius))
    rows.sort(key=lambda row: row[1])
    return Shots(
        frames=tuple(row[0] for row in rows),
        times_s=np.array([row[1] for row in rows], float),
        f_hz=np.array([row[2] for row in rows], float),
        std_hz=np.array([row[3] for row in rows], float),
        celsius=np.array([row[4] for row in rows], float),
        refused=tuple(refused),
    )


def _time_of(measurement: Measurement, frame: int) -> float:
    stamp = measurement.recording.frame_info[frame].time_stamp if isinstance(measurement, VoltageMeasurement) else None
    if not stamp:
        remedy = "use recordings of this software, or another format that keeps them"
        raise InputError("its shots have no times", where=str(measurement.path), remedy=remedy)
    return datetime.fromisoformat(stamp).timestamp()


def joined(parts: Sequence[Shots]) -> Shots:
    """The shots of several recordings, in the order of time; frames are counted through."""
    order = np.argsort(np.concatenate([part.times_s for part in parts]), kind="stable")

    def together(name: str) -> Array:
        return np.asarray(np.concatenate([getattr(part, name) for part in parts])[order])

    return Shots(
        frames=tuple(range(len(order))),
        times_s=together("times_s"),
        f_hz=together("f_hz"),
        std_hz=together("std_hz"),
        celsius=together("celsius"),
        refused=tuple(each for part in parts for each in part.refused),
    )


def key_of(specimen: str) -> str:
    """Name of a file for a specimen: letters, digits and hyphens."""
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
) -> MeasurandCalibration:
    """The calibration of a specimen by readings of a reference.

    Raises InputError for too few pairs, a temperature that is to be corrected for and was not measured, a lag longer
    than declared, and a curve that turns within its range, so that two values have the same frequency.
    """
    longest = measurand.longest_lag_s
    usable = reference.covered(shots.times_s) & reference.covered(shots.times_s + longest)
    warm = measurand.corrected_for == "temperature"
    if warm and not np.isfinite(shots.celsius[usable]).all():
        remedy = "record with a thermometer, or leave corrected_for out"
        raise InputError("the temperature was not measured", where=name, remedy=remedy)
    if not usable.any():
        why = f"the shots were made from {_stamp(shots.times_s.min())} to {_stamp(shots.times_s.max())}"
        why += f", the reference was read from {_stamp(reference.times_s[0])} to {_stamp(reference.times_s[-1])}"
        remedy = "check zone and clock of the reference"
        raise InputError("no shot has a reading of the reference", where=name, why=why, remedy=remedy)
    times, f, std = shots.times_s[usable], shots.f_hz[usable], shots.std_hz[usable]

    def points_at(lag_s: float) -> Points:
        x, u_x = reference.at(times, lag_s)
        return Points(x, u_x, f, std, shots.celsius[usable] if warm else None)

    curve = _curve(measurand, points_at(0.0))
    lag = lag_std = None
    if longest > 0.0:
        found, points, lag, lag_std = with_lag(curve, points_at, longest)
    else:
        points = points_at(0.0)
        found = fit_curve(curve, points)
    if turns := turning_points(found):
        at = ", ".join(f"{each:.6g} {measurand.unit}" for each in turns)
        what = "two values have the same frequency: the inverse is ambiguous"
        remedy = "calibrate on one side of it only, or choose a lower degree"
        raise InputError(what, where=f"{name}, {measurand.name}", why=f"f turns at {at}", remedy=remedy)
    rising = np.sign(np.gradient(reference.at(times, lag or 0.0)[0], times))
    days = (times - times.mean()) / SECONDS_PER_DAY
    by_temperature = None
    if not warm and np.isfinite(shots.celsius[usable]).all() and float(np.ptp(shots.celsius[usable])) > 0.0:
        by_temperature = _test(trend_in(found, points, shots.celsius[usable] - shots.celsius[usable].mean()))
    checked = cross_validated(curve, points)
    middle = np.array([fmean(found.x_range)])
    names = (*curve.names, "per_k") if warm else curve.names
    notes = []
    if measurand.reference is None:
        notes.append("what the readings of the reference have in common is not declared: U does not contain it")
    if by_temperature is not None and by_temperature.significant:
        notes.append("f changes with the temperature, which the measurand is not corrected for: see corrected_for")
    polynomial = curve if isinstance(curve, Polynomial) else None
    celsius = shots.celsius[usable]
    measured = bool(np.isfinite(celsius).all())
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
        parameters=dict(zip(names, found.parameters.tolist(), strict=True)),
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
        cross_validation=CrossValidationReport(rms=checked.rms, covered=checked.covered, readings=checked.readings),
        reference=_reference_u(measurand),
        resolution=found.scatter / abs(float(found.slope(middle)[0])),
        pairs=int(usable.sum()),
        dropped=int((~usable).sum()) + len(shots.refused),
        began=_stamp(times[0]),
        ended=_stamp(times[-1]),
        software_version=__version__,
        files=file_digests(files),
        notes=tuple(notes),
    )


def _curve(measurand: Measurand, points: Points) -> Curve:
    if measurand.model == "polynomial":
        low, high = float(points.x.min()), float(points.x.max())
        return Polynomial(measurand.degree, 0.5 * (low + high), 0.5 * (high - low) or 1.0)
    return _named(measurand.model)


def _named(model: str) -> Curve:
    if model == "dipole":
        return Dipole()
    made: Curve = load(MODELS, model, "model of a measurand")()
    return made


def _reference_u(measurand: Measurand) -> ReferenceU | None:
    if (known := measurand.reference) is None:
        return None
    source = known.source or "[measurand] reference"
    if known.certificate is not None:
        source += f", certificate {known.certificate.number} of {known.certificate.date}"
    return ReferenceU(u=known.standard_uncertainty, distribution=known.distribution, source=source)


def _test(found: Trend) -> ResidualTest:
    return ResidualTest(
        value=found.value, u=found.u, probability=found.probability, significant=found.probability < SIGNIFICANT
    )


def _stamp(seconds: float) -> str:
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds")


@dataclass(frozen=True, eq=False)
class Sensor:
    """A resonator that reads a quantity by its calibration."""

    calibration: MeasurandCalibration
    curve: CalibratedCurve

    @classmethod
    def by(cls, made: MeasurandCalibration) -> Sensor:
        """Of a calibration.  Raises ConfigError for a model that is not installed."""
        curve = Polynomial(made.degree, made.centre, made.scale) if made.model == "polynomial" else _named(made.model)
        found = CalibratedCurve(
            curve=curve,
            parameters=np.array(list(made.parameters.values())),
            covariance=np.array(made.covariance),
            x_range=(made.valid_from, made.valid_to),
            scatter=made.scatter_hz,
            dof=made.dof,
            chi2_per_dof=made.chi2_per_dof,
            second_at=made.temperature_c,
        )
        return cls(made, found)

    def read(
        self,
        f_hz: float,
        celsius: float | None,
        at_s: float | None,
        *,
        shots: int = 1,
        coverage: float = 0.95,
        extrapolate: bool = False,
    ) -> tuple[Budget, bool]:
        """The measurand for a natural frequency, Hz, or the mean of several; and whether it is extrapolated.

        celsius: temperature, degrees Celsius; at_s: when, s since 1970, None: not known, so that no drift counts.
        Raises InputError for one outside of the range by more than U unless `extrapolate`, and for a temperature that
        is missing or outside of that of the calibration.
        """
        made = self.calibration
        second = None
        if made.temperature_c is not None:
            second = self._temperature(celsius, extrapolate)
        low, high = made.valid_from, made.valid_to
        width = high - low
        places = (
            ((low, high), (low - width, high + width)) if not extrapolate else ((low - 3 * width, high + 3 * width),)
        )
        for k, within in enumerate(places):
            try:
                told = self._budget(f_hz, second, at_s, shots, coverage, within)
            except InputError:
                if k + 1 == len(places):
                    raise self._outside(f_hz) from None
                continue
            outside = not low <= told.value <= high
            if outside and not extrapolate and not low - told.expanded <= told.value <= high + told.expanded:
                raise self._outside(f_hz)
            return told, outside
        raise self._outside(f_hz)

    def _budget(
        self,
        f_hz: float,
        second: float | None,
        at_s: float | None,
        shots: int,
        coverage: float,
        within: tuple[float, float],
    ) -> Budget:
        made, curve = self.calibration, self.curve
        slope = abs(float(curve.slope(np.array([curve.inverse(f_hz, second, within=within)]))[0]))
        common = []
        if made.reference is not None:
            common.append(
                InputQuantity(
                    name="reference", value=0.0, u=made.reference.u, distribution=made.reference.distribution,
                    source=made.reference.source,
                )
            )  # fmt: skip
        if made.hysteresis_hz.significant:
            source = "half of the difference of rising and falling"
            size = abs(made.hysteresis_hz.value) / slope
            common.append(InputQuantity.within("hysteresis", 0.0, size, source=source))
        if made.drift_hz_per_day.significant and at_s is not None:
            ended = datetime.fromisoformat(made.ended).timestamp()
            began = datetime.fromisoformat(made.began).timestamp()
            days = abs(at_s - 0.5 * (began + ended)) / SECONDS_PER_DAY
            size = days * math.hypot(made.drift_hz_per_day.value, made.drift_hz_per_day.u) / slope
            if size > 0.0:
                source = f"{days:.3g} days from the middle of the calibration"
                common.append(InputQuantity.within("drift since the calibration", 0.0, size, source=source))
        return curve.read(
            made.name, f_hz, second, readings=shots, common=tuple(common), coverage=coverage, within=within
        )

    def _temperature(self, celsius: float | None, extrapolate: bool) -> float:
        made = self.calibration
        if celsius is None or not math.isfinite(celsius):
            remedy = "record with a thermometer, or calibrate without corrected_for"
            raise InputError("the temperature was not measured", where=made.label, remedy=remedy)
        low, high = made.temperature_from_c, made.temperature_to_c
        assert low is not None
        assert high is not None
        wide = 0.1 * (high - low)
        if not extrapolate and not low - wide <= celsius <= high + wide:
            what = f"{celsius:.2f} °C is outside of the temperatures of the calibration, {low:.2f} to {high:.2f} °C"
            remedy = "calibrate over a wider range, or ask for an extrapolation (--extrapolate)"
            raise InputError(what, where=made.label, remedy=remedy)
        return celsius

    def _outside(self, f_hz: float) -> InputError:
        made = self.calibration
        what = f"{f_hz:.9g} Hz is outside of the calibration, {made.valid_from:g} to {made.valid_to:g} {made.unit}"
        remedy = "calibrate over a wider range, or ask for an extrapolation (--extrapolate) and judge it"
        return InputError(what, where=made.label, remedy=remedy)


def report_of(
    file: str, shots: Shots, made: MeasurandCalibration, *, coverage: float = 0.95, extrapolate: bool = False
) -> MeasurandReport:
    """Every shot as a reading, and the mean of all.  Shots outside of the range are listed with the reason."""
    sensor = Sensor.by(made)
    told: list[MeasurandReading] = []
    refused = list(shots.refused)
    for k, frame in enumerate(shots.frames):
        celsius = _known(float(shots.celsius[k]))
        at = float(shots.times_s[k])
        try:
            found, outside = sensor.read(float(shots.f_hz[k]), celsius, at, coverage=coverage, extrapolate=extrapolate)
        except InputError as error:
            refused.append(UnreadShot(frame=frame, reason=str(error)))
            continue
        told.append(_reading(found, (frame,), at, float(shots.f_hz[k]), celsius, outside))
    missing = [] if made.reference is not None else ["what the readings of the reference have in common"]
    return MeasurandReport(
        file=file,
        calibration=made.label,
        name=made.name,
        unit=made.unit,
        shots=tuple(told),
        mean=_mean(sensor, told, coverage, extrapolate),
        refused=tuple(sorted(refused, key=lambda each: each.frame)),
        not_declared=tuple(missing),
    )


def _mean(
    sensor: Sensor, told: Sequence[MeasurandReading], coverage: float, extrapolate: bool
) -> MeasurandReading | None:
    """Of all shots together; None of fewer than two, or of a mean outside of the range."""
    if len(told) < 2:
        return None
    f = fmean(each.f_nat_hz for each in told)
    celsius = [each.temperature_c for each in told if each.temperature_c is not None]
    at = _seconds(told[0].at)
    try:
        found, outside = sensor.read(
            f, fmean(celsius) if celsius else None, at, shots=len(told), coverage=coverage, extrapolate=extrapolate
        )
    except InputError:
        return None
    frames = tuple(frame for each in told for frame in each.frames)
    return _reading(found, frames, at, f, fmean(celsius) if celsius else None, outside)


def _reading(
    found: Budget, frames: tuple[int, ...], at_s: float | None, f: float, celsius: float | None, outside: bool
) -> MeasurandReading:
    written = budget_report(found)
    return MeasurandReading(
        frames=frames,
        at=None if at_s is None else _stamp(at_s),
        value=written.value,
        u=written.u,
        dof=written.dof,
        k=written.k,
        U=written.U,
        coverage=written.coverage,
        f_nat_hz=f,
        temperature_c=celsius,
        extrapolated=outside,
        inputs=written.inputs,
    )


def _known(celsius: float) -> float | None:
    return celsius if math.isfinite(celsius) else None


def _seconds(stamp: str | None) -> float | None:
    return None if stamp is None else datetime.fromisoformat(stamp).timestamp()
