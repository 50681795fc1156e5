"""Reading a resonator by its calibration."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from statistics import fmean
from typing import TYPE_CHECKING

import numpy as np

from drivers.entry_points import MEASURAND_MODELS, load
from drivers.errors import ConfigError, InputError
from platform_daemon.uncertainty.budget import Budget
from platform_daemon.uncertainty.calibration_curve import CalibratedCurve, one_branch
from platform_daemon.uncertainty.curves import Curve, Dipole, Polynomial
from platform_daemon.uncertainty.inputs import InputQuantity

from .schema import MeasurandCalibration, MeasurandReading, MeasurandReport, UnreadShot

if TYPE_CHECKING:
    from .shots import Shots

SECONDS_PER_DAY = 86400.0


class OutsideCalibration(InputError):
    """A frequency or a temperature that the calibration does not hold for."""


def named_curve(model: str) -> Curve:
    """The dipole law, or what an entry point makes.  Raises ConfigError for a name that is not installed."""
    if model == "dipole":
        return Dipole()
    try:
        made: Curve = load(MEASURAND_MODELS, model, "model of a measurand")()
    except ConfigError as error:
        where, why = error.where or "[measurand] model", f"there are polynomial and dipole; {error.why}"
        raise ConfigError(error.what, where=where, why=why, remedy=error.remedy) from None
    return made


def stamp(seconds: float) -> str:
    """ISO 8601 of s since 1970."""
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="milliseconds")


@dataclass(frozen=True, eq=False)
class Sensor:
    """A resonator that reads a quantity by its calibration."""

    calibration: MeasurandCalibration
    curve: CalibratedCurve

    @classmethod
    def by(cls, made: MeasurandCalibration) -> Sensor:
        """Of a calibration.  Raises ConfigError for a model that is not installed."""
        curve = (
            Polynomial(made.degree, made.centre, made.scale) if made.model == "polynomial" else named_curve(made.model)
        )
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
        A temperature outside of those of the calibration by less than a tenth of their range counts as extrapolated.
        Raises OutsideCalibration for one outside of the range by more than U unless `extrapolate`, and for a
        temperature that is further outside, InputError for one that is missing.
        """
        made = self.calibration
        second, warmer = None, False
        if made.temperature_c is not None:
            second, warmer = self._temperature(celsius, extrapolate)
        low, high = made.valid_from, made.valid_to
        try:
            told = self._budget(f_hz, second, at_s, shots, coverage, (low, high))
        except InputError:
            far = (3.0 if extrapolate else 1.0) * (high - low)
            within = one_branch(self.curve, (low - far, high + far))
            try:
                told = self._budget(f_hz, second, at_s, shots, coverage, within)
            except InputError:
                raise self._beyond(f_hz, within) if extrapolate else self._outside(f_hz) from None
        outside = not low <= told.value <= high
        if outside and not extrapolate and not low - told.expanded <= told.value <= high + told.expanded:
            raise self._outside(f_hz)
        return told, outside or warmer

    def place(self, f_hz: float, celsius: float | None) -> float:
        """The measurand for a natural frequency, Hz, without its uncertainty, up to a width of the range outside of it.

        celsius: temperature, degrees Celsius.  Raises InputError further outside, and where the temperature is missing.
        """
        made = self.calibration
        second = None if made.temperature_c is None else self._temperature(celsius, extrapolate=True)[0]
        width = made.valid_to - made.valid_from
        within = one_branch(self.curve, (made.valid_from - width, made.valid_to + width))
        return self.curve.inverse(f_hz, second, within=within)

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
        x = curve.inverse(f_hz, second, within=within)
        slope = abs(float(curve.slope(np.array([x]))[0]))
        common = []
        if (known := made.reference) is not None:
            common.append(
                InputQuantity(
                    name="reference", value=0.0, u=known.u, distribution=known.distribution, kind=known.type,
                    dof=math.inf if known.dof is None else known.dof, source=known.source,
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
        return curve.read(made.name, f_hz, second, readings=shots, common=tuple(common), coverage=coverage, x=x)

    def _temperature(self, celsius: float | None, extrapolate: bool) -> tuple[float, bool]:
        """The temperature to correct for, and whether the calibration has seen none like it."""
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
            raise OutsideCalibration(what, where=made.label, remedy=remedy)
        return celsius, not low <= celsius <= high

    def _outside(self, f_hz: float) -> OutsideCalibration:
        made = self.calibration
        what = f"{f_hz:.9g} Hz is outside of the calibration, {made.valid_from:g} to {made.valid_to:g} {made.unit}"
        remedy = "calibrate over a wider range, or ask for an extrapolation (--extrapolate) and judge it"
        return OutsideCalibration(what, where=made.label, remedy=remedy)

    def _beyond(self, f_hz: float, within: tuple[float, float]) -> OutsideCalibration:
        made, (low, high) = self.calibration, within
        width = made.valid_to - made.valid_from
        why = "that is three times its range on either side"
        if low > made.valid_from - 2.9 * width or high < made.valid_to + 2.9 * width:
            why = "the curve turns there, and the inverse is ambiguous beyond"
        what = f"{f_hz:.9g} Hz is beyond what the calibration is extrapolated to, {low:g} to {high:g} {made.unit}"
        return OutsideCalibration(what, where=made.label, why=why, remedy="calibrate over a wider range")


def report_of(
    file: str, shots: Shots, made: MeasurandCalibration, *, coverage: float = 0.95, extrapolate: bool = False
) -> MeasurandReport:
    """Every shot as a reading, and the mean of all.  Shots outside of the range are listed with the reason, and with
    one of them there is no mean."""
    sensor = Sensor.by(made)
    told: list[MeasurandReading] = []
    refused = list(shots.refused)
    beyond = 0
    for k, frame in enumerate(shots.frames):
        celsius = _known(float(shots.celsius[k]))
        at = float(shots.times_s[k])
        try:
            found, outside = sensor.read(float(shots.f_hz[k]), celsius, at, coverage=coverage, extrapolate=extrapolate)
        except InputError as error:
            refused.append(UnreadShot(frame=frame, reason=str(error)))
            beyond += isinstance(error, OutsideCalibration)
            continue
        told.append(_reading(found, (frame,), at, float(shots.f_hz[k]), celsius, outside))
    missing = [] if made.reference is not None else ["what the readings of the reference have in common"]
    mean, why = _mean(sensor, told, beyond, coverage, extrapolate)
    return MeasurandReport(
        file=file,
        calibration=made.label,
        name=made.name,
        unit=made.unit,
        shots=tuple(told),
        mean=mean,
        mean_reason=why,
        refused=tuple(sorted(refused, key=lambda each: each.frame)),
        not_declared=tuple(missing),
    )


def _mean(
    sensor: Sensor, told: Sequence[MeasurandReading], beyond: int, coverage: float, extrapolate: bool
) -> tuple[MeasurandReading | None, str | None]:
    """Of all shots together, or why there is none; beyond: shots that the calibration does not hold for."""
    if len(told) < 2:
        return None, f"{len(told)} of the shots have a reading, and a mean needs two"
    if beyond:
        what = f"{beyond} of the shots lie outside of the calibration"
        return None, f"{what}, and the mean of the others would be drawn into its range"
    f = fmean(each.f_nat_hz for each in told)
    celsius = [each.temperature_c for each in told if each.temperature_c is not None]
    at = _seconds(told[0].at)
    try:
        found, outside = sensor.read(
            f, fmean(celsius) if celsius else None, at, shots=len(told), coverage=coverage, extrapolate=extrapolate
        )
    except InputError as error:
        return None, str(error)
    frames = tuple(frame for each in told for frame in each.frames)
    return _reading(found, frames, at, f, fmean(celsius) if celsius else None, outside), None


def _reading(
    found: Budget, frames: tuple[int, ...], at_s: float | None, f: float, celsius: float | None, outside: bool
) -> MeasurandReading:
    from platform_daemon.features.budget.written import budget_report  # fits, which a reading alone does not need

    written = budget_report(found)
    return MeasurandReading(
        frames=frames,
        at=None if at_s is None else stamp(at_s),
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
