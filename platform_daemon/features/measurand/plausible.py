"""Mistakes of a reference that its numbers show: an uncertainty or a temperature in another unit, times of another
zone."""

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

_BY_CELSIUS: dict[str, Callable[[Array], Array]] = {
    "degC": lambda celsius: celsius,
    "K": lambda celsius: celsius + 273.15,
    "degF": lambda celsius: 1.8 * celsius + 32.0,
}
_ALIKE = 1.0
"""In another unit the readings agree with the platform's thermometer to as much, rms: it is beside the resonator, and
of two thermometers in one room neither is off by more."""
_UNLIKE = 10.0
"""Times as much they differ in the unit that is declared: a resonator in a warm chamber may be warmer than the
thermometer, but by just what a change of the unit makes of its temperature only by chance."""
_BETTER = 3.0
"""Times less is left over with the reference shifted by whole hours.  A reference that is right leaves noise, which no
shift makes less; white noise of 20 pairs is never as uneven."""
_FEWEST, _SPAN = 20, 3.0
"""Pairs that a shift leaves, and the span of the shots in shifts: slow changes look alike over less."""
_MOST_HOURS = 14  # a local time is at most so far from UTC


def refuse_vague(measurand: Measurand, points: Points, where: str) -> None:
    """Raises InputError for a reference that changes by less than its readings are uncertain."""
    change, u = float(np.ptp(points.x)), float(np.median(points.u_x))
    if 0.0 < change <= u:
        what = f"the reference changes by {change:.3g} {measurand.unit}, and its readings have u = {u:.3g}"
        remedy = "check the column u, which is in the unit of the readings, or let the reference change by more"
        raise InputError(what, where=where, why="no curve shows in them", remedy=remedy)


def refuse_other_unit(measurand: Measurand, values: Array, celsius: Array, where: str) -> None:
    """Of a temperature, by what the platform's thermometer read with the shots.

    values: of the reference, (n,), at the shots; celsius: (n,), NaN where nothing was read.  Raises InputError for
    readings that agree with it if they are taken to be in another unit, and else not.
    """
    declared, read = unit_of(measurand.unit), np.isfinite(celsius)
    if measurand.name.casefold() != "temperature" or declared not in _BY_CELSIUS or not read.any():
        return
    apart = {
        unit: math.sqrt(float(np.mean((values[read] - by_celsius(celsius[read])) ** 2)))
        for unit, by_celsius in _BY_CELSIUS.items()
    }
    closest = min(apart, key=lambda unit: apart[unit])
    if closest == declared or apart[closest] > _ALIKE or apart[declared] < _UNLIKE * apart[closest]:
        return
    what = f"the readings of the reference are in {closest}, it seems, and not in {measurand.unit}"
    why = f"their mean is {float(values[read].mean()):.5g} where the platform's thermometer read "
    why += f"{float(celsius[read].mean()):.4g} degC"
    raise InputError(what, where=where, why=why, remedy=f"convert them to {measurand.unit}")


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
    for hours in (h for h in range(-_MOST_HOURS, _MOST_HOURS + 1) if h):
        moved = Reference(reference.times_s + 3600.0 * hours, reference.values, reference.u)
        there = np.flatnonzero(moved.covered(times_s))
        if len(there) < max(_FEWEST, len(points.x) // 2) or np.ptp(times_s[there]) < _SPAN * 3600.0 * abs(hours):
            continue
        others = pairs(moved, there)
        try:
            best = min(best, (_rms(fit_curve(curve, others), others), hours))
        except InputError:  # at that time the reference was at rest
            continue
    left, hours = best
    if hours and _BETTER * left < before:
        what = "the times of the reference are wrong, it seems"
        why = f"shifted by {hours:+d} h they leave {1e3 * left:.3g} mHz of the frequency unexplained, as they are "
        why += f"{1e3 * before:.3g} mHz"
        remedy = "check zone and clock of the reference, or declare longest_lag_s if the resonator follows it so late"
        raise InputError(what, where=where, why=why, remedy=remedy)


def _rms(found: CalibratedCurve, points: Points) -> float:
    return math.sqrt(float(np.mean(left_over(found, points) ** 2)))
