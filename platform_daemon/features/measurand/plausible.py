"""Mistakes of a reference that its numbers show: an uncertainty or readings in another unit, times of another zone."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from drivers.errors import InputError
from drivers.specimen import Measurand
from platform_daemon.uncertainty.calibration_curve import CalibratedCurve, Points, fit_curve, left_over
from platform_daemon.uncertainty.curves import Curve
from platform_daemon.uncertainty.inputs import Array

from .reference_file import Reference, unit_of
from .schema import MeasurandCalibration
from .thresholds import (
    AIR_PA,
    ALIKE_K,
    BETTER,
    FACTOR_FEWEST,
    FACTOR_WITHIN,
    MOST_HOURS,
    UNLIKE,
    ZONE_FEWEST,
    ZONE_SPAN,
)

_BY_CELSIUS: dict[str, Callable[[Array], Array]] = {
    "degC": lambda celsius: celsius,
    "K": lambda celsius: celsius + 273.15,
    "degF": lambda celsius: 1.8 * celsius + 32.0,
}
_PA = {
    "Pa": 1.0,
    "hPa": 1e2,
    "mbar": 1e2,
    "kPa": 1e3,
    "MPa": 1e6,
    "bar": 1e5,
    "atm": 101325.0,
    "Torr": 133.322368,
    "mmHg": 133.322387,
    "psi": 6894.757,
}
"""Units of pressure (SI brochure, 9th ed.; NIST SP 811, B.8)."""


def refuse_vague(measurand: Measurand, points: Points, where: str) -> None:
    """Raises InputError for a reference that changes by less than its readings are uncertain."""
    change, u = float(np.ptp(points.x)), float(np.median(points.u_x))
    if 0.0 < change <= u:
        what = f"the reference changes by {change:.3g} {measurand.unit}, and its readings have u = {u:.3g}"
        remedy = "check the column u, which is in the unit of the readings, or let the reference change by more"
        raise InputError(what, where=where, why="no curve shows in them", remedy=remedy)


def refuse_other_unit(measurand: Measurand, values: Array, celsius: Array, where: str) -> None:
    """Of a pressure, by that of the air; of a temperature, by what the platform's thermometer read with the shots.

    values: of the reference, (n,), at the shots; celsius: (n,), NaN where nothing was read.  Raises InputError for
    readings that agree with it if they are taken to be in another unit, and else not; and for readings of which none
    lies within the limits that the measurand declares.
    """
    declared, read = unit_of(measurand.unit), np.isfinite(celsius)
    _refuse_beyond_limits(measurand, values, where)
    if declared in _PA:
        _refuse_other_pressure(measurand, values, where)
    if measurand.name.casefold() != "temperature" or declared not in _BY_CELSIUS or not read.any():
        return
    apart = {
        unit: math.sqrt(float(np.mean((values[read] - by_celsius(celsius[read])) ** 2)))
        for unit, by_celsius in _BY_CELSIUS.items()
    }
    closest = min(apart, key=lambda unit: apart[unit])
    if closest == declared or apart[closest] > ALIKE_K or apart[declared] < UNLIKE * apart[closest]:
        return
    what = f"the readings of the reference are in {closest}, it seems, and not in {measurand.unit}"
    why = f"their mean is {float(values[read].mean()):.5g} where the platform's thermometer read "
    why += f"{float(celsius[read].mean()):.4g} degC"
    raise InputError(what, where=where, why=why, remedy=f"convert them to {measurand.unit}")


def _refuse_beyond_limits(measurand: Measurand, values: Array, where: str) -> None:
    low = -math.inf if measurand.lowest is None else measurand.lowest
    high = math.inf if measurand.highest is None else measurand.highest
    if not ((low <= values) & (values <= high)).any():
        what = "no reading of the reference lies within the limits of the measurand"
        why = f"it reads {values.min():.5g} to {values.max():.5g} {measurand.unit}, lowest and highest are "
        why += f"{low:g} and {high:g}"
        raise InputError(what, where=where, why=why, remedy="check the unit of the readings, or correct the limits")


def _refuse_other_pressure(measurand: Measurand, values: Array, where: str) -> None:
    """Limits that contain all readings say that they are meant."""
    ends = float(values.min()), float(values.max())
    meant = measurand.lowest is not None and measurand.highest is not None
    if meant and measurand.lowest <= ends[0] and ends[1] <= measurand.highest:  # type: ignore[operator]
        return
    factor = _PA[unit_of(measurand.unit)]
    low, high = AIR_PA
    if ends[0] * factor <= high and ends[1] * factor >= low:
        return
    seems = next((u for u, pa in _PA.items() if low <= ends[0] * pa and ends[1] * pa <= high), None)
    if seems is not None:
        what = f"the readings of the reference are in {seems}, it seems, and not in {measurand.unit}"
        why = f"they go from {ends[0]:.5g} to {ends[1]:.5g}, which in {seems} is the pressure of the air"
        remedy = f"convert them to {measurand.unit}; if they are right, declare lowest and highest that contain them"
        raise InputError(what, where=where, why=why, remedy=remedy)


def refuse_other_scale(
    before: MeasurandCalibration, f_hz: Array, celsius: Array, values: Array, unit: str, where: str
) -> None:
    """By an earlier calibration: the same frequencies would read a power of ten more or less.

    f_hz, celsius, values: (n,) of the shots, and of the reference at them.  Raises InputError; a calibration of another
    quantity says nothing, and neither do shots outside of its range.
    """
    from .sensor import Sensor

    if unit_of(before.unit) != unit_of(unit):
        return
    sensor, ratios = Sensor.by(before), []
    for f, warm, value in zip(f_hz, celsius, values, strict=True):
        try:
            read = sensor.place(float(f), float(warm) if math.isfinite(warm) else None)
        except InputError:
            continue
        if read * value > 0.0:
            ratios.append(value / read)
    if len(ratios) < FACTOR_FEWEST:
        return
    middle = float(np.median(ratios))
    decades = round(math.log10(middle))
    if decades and np.quantile(np.abs(np.array(ratios) / 10.0**decades - 1.0), 0.9) < FACTOR_WITHIN:
        what = "the readings of the reference are in another unit than those of the calibration before, it seems"
        why = f"they are {10.0**decades:g} times what {before.label} reads of the same frequencies, in {unit}"
        remedy = f"convert them; if it is {before.label} that is wrong, remove its file"
        raise InputError(what, where=where, why=why, remedy=remedy)


def refuse_other_zone(
    curve: Curve,
    found: CalibratedCurve,
    points: Points,
    times_s: Array,
    reference: Reference,
    pairs: Callable[[Reference, NDArray[np.intp]], Points],
    where: str,
) -> None:
    """By whether the reference explains the shots far better with its times shifted by whole hours.

    found, points: the calibration and its pairs; times_s: (n,) of the shots, NaN: not to be used; pairs: makes those of
    a reference and of places of shots.  Raises InputError.
    """
    before = _rms(found, points)
    best = (before, 0)
    for hours in (h for h in range(-MOST_HOURS, MOST_HOURS + 1) if h):
        moved = Reference(reference.times_s + 3600.0 * hours, reference.values, reference.u)
        there = np.flatnonzero(moved.covered(times_s))
        if len(there) < max(ZONE_FEWEST, len(points.x) // 2) or np.ptp(times_s[there]) < ZONE_SPAN * 3600.0 * abs(
            hours
        ):
            continue
        others = pairs(moved, there)
        try:
            best = min(best, (_rms(fit_curve(curve, others), others), hours))
        except InputError:  # at that time the reference was at rest
            continue
    left, hours = best
    if hours and BETTER * left < before:
        what = "the times of the reference are wrong, it seems"
        why = f"shifted by {hours:+d} h they leave {1e3 * left:.3g} mHz of the frequency unexplained, as they are "
        why += f"{1e3 * before:.3g} mHz"
        remedy = "check zone and clock of the reference, or declare longest_lag_s if the resonator follows it so late"
        raise InputError(what, where=where, why=why, remedy=remedy)


def _rms(found: CalibratedCurve, points: Points) -> float:
    return math.sqrt(float(np.mean(left_over(found, points) ** 2)))
