"""Readings of a reference: a CSV file with times, values and, where known, the standard uncertainty of each."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivers.errors import InputError
from drivers.specimen import Measurand
from drivers.text_files import read_text_file

Array = NDArray[np.float64]
_HEADING = re.compile(r"(?P<name>[^\[]*?)\s*\[(?P<unit>[^\]]*)\]\s*")
_SEPARATORS = {";": "semicolons", "\t": "tabs"}
_GAP = 5.0  # times the median distance of readings: between readings further apart nothing is interpolated


@dataclass(frozen=True, eq=False)
class Reference:
    """Readings in the order of time.

    Attributes:
        times_s: (n,) s since 1970; values: (n,); u: (n,) standard uncertainty of each by itself.
    """

    times_s: Array
    values: Array
    u: Array

    def covered(self, times_s: Array) -> NDArray[np.bool_]:
        """Which times are those of readings, or lie between two that are not far apart, (m,)."""
        steps = np.diff(self.times_s)
        place = np.searchsorted(self.times_s, times_s)
        there = self.times_s[np.minimum(place, len(self.times_s) - 1)] == times_s
        inside = (place > 0) & (place < len(self.times_s))
        wide = steps > _GAP * float(np.median(steps))
        found: NDArray[np.bool_] = there | (inside & ~wide[np.clip(place - 1, 0, len(steps) - 1)])
        return found

    def at(self, times_s: Array, lag_s: float = 0.0) -> tuple[Array, Array]:
        """Values and their standard uncertainties as something sees them that follows the reference.

        lag_s above 0: of first order, in equilibrium at the first reading; below 0: it precedes the reference by that
        time, to first order in it.  Between readings they are interpolated, so that neighbours share their errors.
        """
        values = self.values if lag_s <= 0.0 else _low_pass(self.times_s, self.values, lag_s)
        at = times_s - min(lag_s, 0.0)
        u = np.interp(at, self.times_s, self.u)
        if lag_s > 0.0:  # an exponential mean over about 2 lag / step readings
            step = float(np.median(np.diff(self.times_s)))
            u = u * math.sqrt(min(1.0, step / (2.0 * lag_s + step)))
        return np.interp(at, self.times_s, values), u


def _low_pass(times_s: Array, values: Array, lag_s: float) -> Array:
    """Response of first order to a signal that is linear between readings."""
    found = np.empty_like(values)
    found[0] = values[0]
    steps = np.diff(times_s)
    slopes, keep = np.diff(values) / steps, np.exp(-steps / lag_s)
    for k in range(len(steps)):
        behind = slopes[k] * lag_s
        found[k + 1] = values[k + 1] - behind + (found[k] - values[k] + behind) * keep[k]
    return found


def read_reference(path: Path, measurand: Measurand) -> Reference:
    """The readings in a file, see `reference_from`.  Raises InputError for a file that cannot be read, too."""
    try:
        text = read_text_file(path)
    except (OSError, ValueError) as error:
        raise _unreadable(str(path), error) from None
    return reference_from(text, str(path), measurand)


def reference_from(text: str, where: str, measurand: Measurand) -> Reference:
    """Readings as CSV: a heading `time,NAME [UNIT]` or `time,NAME [UNIT],u [UNIT]`, times in ISO 8601 with their zone.

    Raises InputError for another unit, a time without a zone or out of order, an uncertainty that is not above 0, and
    anything that is no number.  where: as messages name it.
    """
    try:
        rows = list(csv.reader(text.removeprefix("\ufeff").splitlines()))
    except csv.Error as error:
        raise _unreadable(where, error) from None
    if sum(map(bool, rows)) < 3:
        remedy = "give a heading and a line for each reading"
        raise InputError("fewer than two readings", where=where, remedy=remedy)
    with_u = _check_heading(where, rows[0], measurand)
    table = [_line(where, number, row, with_u) for number, row in enumerate(rows[1:], start=2) if row]
    times, values, u = (np.array(column) for column in zip(*table, strict=True))
    if (np.diff(times) <= 0.0).any():
        number = int(np.argmax(np.diff(times) <= 0.0)) + 3
        remedy = "sort the readings, each time once"
        raise InputError("the time is not after the one before", where=f"{where}, line {number}", remedy=remedy)
    return Reference(times, values, u)


def _unreadable(where: str, error: Exception) -> InputError:
    remedy = "give a CSV file in UTF-8"
    return InputError("the reference cannot be read", where=where, why=str(error), remedy=remedy)


def _check_heading(place: str, heading: list[str], measurand: Measurand) -> bool:
    """Whether there is a column with uncertainties."""
    wanted = f"time,{measurand.name} [{measurand.unit}],u [{measurand.unit}]"
    where, remedy = f"{place}, line 1", f"write the heading {wanted!r}; u may be missing"
    if len(heading) not in (2, 3) or heading[0].strip() != "time":
        other = next((name for sign, name in _SEPARATORS.items() if sign in ",".join(heading)), None)
        why = "" if other is None else f"it has {other}: columns are separated by commas, numbers have points"
        raise InputError("the heading is not that of a reference", where=where, why=why, remedy=remedy)
    for column, name in zip(heading[1:], (measurand.name, "u"), strict=False):
        found = _HEADING.fullmatch(column)
        if found is None:
            raise InputError(f"the column {column!r} names no unit", where=where, remedy=remedy)
        if unit_of(found["unit"]) != unit_of(measurand.unit):
            what = f"the reference is in {found['unit']}, the measurand in {measurand.unit}"
            raise InputError(what, where=where, remedy="convert the readings, or declare the measurand in that unit")
        if found["name"].strip() != name:
            raise InputError(f"the column is called {found['name'].strip()!r}", where=where, remedy=remedy)
    return len(heading) == 3


def unit_of(text: str) -> str:
    """A unit as it is compared: without blanks around it, degrees in letters."""
    return text.strip().replace("℃", "degC").replace("°", "deg").replace("º", "deg")


def _number(cell: str) -> float:
    """Raises ValueError; 0_02 is 2 to Python, and to nobody else."""
    if "_" in cell:
        raise ValueError(f"could not convert string to float: {cell!r}")
    return float(cell)


def _line(place: str, number: int, row: list[str], with_u: bool) -> tuple[float, float, float]:
    where = f"{place}, line {number}"
    if len(row) != 2 + with_u:
        remedy = f"give {2 + with_u}, as the heading has them, and numbers with a point"
        raise InputError(f"{len(row)} cells", where=where, remedy=remedy)
    try:
        at = datetime.fromisoformat(row[0].strip())
        numbers = [_number(cell) for cell in row[1:]]
    except ValueError as error:
        remedy = "times in ISO 8601, as 2026-01-01T12:00:00+00:00, numbers with a point"
        raise InputError("not a time and numbers", where=where, why=str(error), remedy=remedy) from None
    if at.tzinfo is None:
        remedy = "write it with the zone, as 2026-01-01T12:00:00+01:00 or ...Z"
        raise InputError("the time has no zone", where=where, remedy=remedy)
    if not all(map(math.isfinite, numbers)):
        raise InputError("a number is not finite", where=where, remedy="leave the reading out")
    if with_u and numbers[1] <= 0.0:
        remedy = "give a standard uncertainty above 0, or leave the column out"
        raise InputError(f"the standard uncertainty is {numbers[1]:g}", where=where, remedy=remedy)
    return at.timestamp(), numbers[0], numbers[1] if with_u else 0.0
