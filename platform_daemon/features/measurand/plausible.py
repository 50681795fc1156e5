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

_MEANT = "; if they are right, declare what is expected: expected_from and expected_to of [measurand]"
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
    "cmH2O": 98.0665,
    "inHg": 3386.389,
    "psi": 6894.757,
}
"""Units of pressure (SI brochure, 9th ed.; NIST SP 811, B.8)."""
_OF_AIR = ("air", "atmospher", "baromet", "ambient")
"""A quantity is the pressure of the air if its name contains one of these, or is "pressure" alone."""


def refuse_vague(measurand: Measurand, points: Points, where: str) -> None:
    """Raises InputError for a reference that changes by less than its readings are uncertain."""
    change, u = float(np.ptp(points.x)), float(np.median(points.u_x))
    if 0.0 < change <= u:
        what = f"the reference changes by {change:.3g} {measurand.unit}, and its readings have u = {u:.3g}"
        remedy = "check the column u, which is in the unit of the readings, or let the reference change by more"
        raise InputError(what, where=where, why="no curve shows in them", remedy=remedy)


def refuse_other_unit(measurand: Measurand, values: Array, celsius: Array, where: str) -> None:
    """By what is declared to be expected; else of a pressure of the air, by its size, and of a temperature, by what the
    platform's thermometer read with the shots.

    values: of the reference, (n,), at the shots; celsius: (n,), NaN where nothing was read.  Raises InputError for
    readings of which none is as expected, and for those that are right if they are taken to be in another unit.
    """
    if measurand.expected_from is not None and measurand.expected_to is not None:
        _refuse_unexpected(measurand, measurand.expected_from, measurand.expected_to, values, where)
    elif measurand.name.casefold() == "temperature":
        _refuse_other_temperature(measurand, values, celsius, where)
    elif measurand.name.casefold() == "pressure" or any(each in measurand.name.casefold() for each in _OF_AIR):
        _refuse_other_pressure(measurand, values, where)


def _refuse_unexpected(measurand: Measurand, low: float, high: float, values: Array, where: str) -> None:
    if not ((low <= values) & (values <= high)).any():
        what = "no reading of the reference is as the measurand expects"
        why = f"it reads {values.min():.5g} to {values.max():.5g} {measurand.unit}, expected are {low:g} to {high:g}"
        raise InputError(what, where=where, why=why, remedy="check the unit of the readings, or correct expected_from")


def _refuse_other_temperature(measurand: Measurand, values: Array, celsius: Array, where: str) -> None:
    declared, read = unit_of(measurand.unit), np.isfinite(celsius)
    if declared not in _BY_CELSIUS or not read.any():
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
    raise InputError(what, where=where, why=why, remedy=f"convert them to {measurand.unit}{_MEANT}")


def _refuse_other_pressure(measurand: Measurand, values: Array, where: str) -> None:
    factor = _pascals(measurand.unit)
    low, high = AIR_PA
    lowest, highest = map(float, np.quantile(values, [0.1, 0.9]))  # a reading may be wrong
    if factor is None or (lowest * factor <= high and highest * factor >= low):
        return
    seem = [unit for unit, pa in _PA.items() if low <= lowest * pa and highest * pa <= high]
    if seem:
        what = f"the readings of the reference are in {' or '.join(seem)}, it seems, and not in {measurand.unit}"
        why = f"they go from {lowest:.5g} to {highest:.5g}, which then is the pressure of the air"
        raise InputError(what, where=where, why=why, remedy=f"convert them to {measurand.unit}{_MEANT}")


def _pascals(unit: str) -> float | None:
    """Of a unit of pressure, as it is written or in other letters where that is no other unit; None: it is none."""
    exact = _PA.get(unit_of(unit))
    if exact is not None or unit_of(unit).casefold() == "mpa":  # mPa is not MPa
        return exact
    return next((pa for each, pa in _PA.items() if each.casefold() == unit_of(unit).casefold()), None)


def refuse_other_scale(
    before: MeasurandCalibration, f_hz: Array, celsius: Array, values: Array, measurand: Measurand, where: str
) -> None:
    """By an earlier calibration: the same frequencies would read a power of ten more or less.

    f_hz, celsius, values: (n,) of the shots, and of the reference at them.  Raises InputError.  A calibration of
    another quantity or of a model that is not installed says nothing, and neither do shots outside of its range; where
    it is declared which readings are expected, that decides.
    """
    from .sensor import Sensor

    scale = _scale_between(before.unit, measurand.unit)
    if before.name != measurand.name or scale is None or measurand.expected_from is not None:
        return
    try:
        sensor = Sensor.by(before)
    except InputError:
        return
    pairs = []
    for f, warm, value in zip(f_hz, celsius, values, strict=True):
        try:
            read = sensor.place(float(f), float(warm) if math.isfinite(warm) else None)
        except InputError:
            continue
        pairs.append((scale * read, float(value)))
    if len(pairs) < FACTOR_FEWEST:
        return
    then, now = np.array(pairs).T
    slope = float(then @ now) / float(then @ then) if then.any() else 0.0
    decades = round(math.log10(slope)) if slope > 0.0 else 0
    left = np.sqrt(np.mean((now / 10.0**decades - then) ** 2) / np.mean(then**2)) if decades else math.inf
    if left < FACTOR_WITHIN:
        what = "the readings of the reference are in another unit than those of the calibration before, it seems"
        why = f"they are {10.0**decades:g} times what {before.label} reads of the same frequencies, in {measurand.unit}"
        raise InputError(what, where=where, why=why, remedy=f"convert them{_MEANT}")


def _scale_between(one: str, other: str) -> float | None:
    """A value in the first unit, in the second one; None: not known."""
    if unit_of(one) == unit_of(other):
        return 1.0
    first, second = _pascals(one), _pascals(other)
    return None if first is None or second is None else first / second


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
