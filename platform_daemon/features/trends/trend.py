"""The trend of a specimen, from what the index holds of its recordings."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.errors import InputError
from platform_daemon.core.recordings.indexed import IndexedRecording

from .changes import changes
from .charts import ChartedStretch, charted, shown
from .points import Point, points_of, quantities
from .prediction import LEARNED_FROM
from .schema import TrendPoint, TrendReport

POINTS_TO_FALSE_ALARM = 20_000.0
"""Default, per specimen: with four points a day one false alarm in fourteen years."""
FEWEST, MOST = 100.0, 1e6
_STEPS_NAMED = 5


def specimen_trend(
    specimen: str,
    recordings: Sequence[IndexedRecording],
    points_to_false_alarm: float = POINTS_TO_FALSE_ALARM,
    step: str | None = None,
    newest: int | None = None,
) -> TrendReport:
    """Points, a chart per quantity, and changes with names.

    points_to_false_alarm: mean number of points to an alarm of a specimen that does not change, over all its charts.
    step: of procedures that the points are of, None: the last one.  newest: so many points are listed at most, None:
    all; charts and changes are those of all points in any case.  Raises InputError for one outside 100 to 1e6.
    """
    if not FEWEST <= points_to_false_alarm <= MOST:
        remedy = f"ask for {FEWEST:g} to {MOST:g}"
        what = f"a false alarm in {points_to_false_alarm:g} points"
        raise InputError(what, where="points_to_false_alarm", remedy=remedy)
    points = points_of(recordings)
    stretches = charted(points, points_to_false_alarm)
    by_quantity: dict[str, list[ChartedStretch]] = {name: [] for name in quantities(points)}
    for each in stretches:
        by_quantity[each.quantity].append(each)
    listed = slice(0 if newest is None else max(0, len(points) - newest), None)
    left_out = [f"the newest {newest} of {len(points)} points are listed"] if listed.start else []
    return TrendReport(
        specimen=specimen,
        points=tuple(map(_shown, points[listed])),
        charts=tuple(shown(name, parts, points, listed) for name, parts in by_quantity.items()),
        changes=tuple(changes(stretches, points)),
        points_to_false_alarm=points_to_false_alarm,
        notes=(*left_out, *_step_notes(recordings, step), *_notes(points, by_quantity)),
    )


def _shown(point: Point) -> TrendPoint:
    measured = math.isfinite(point.temperature_c)
    return TrendPoint(
        at=point.at,
        clock=point.clock,
        recording=point.recording,
        shots=point.shots,
        temperature_c=point.temperature_c if measured else None,
    )


def _step_notes(recordings: Sequence[IndexedRecording], step: str | None) -> list[str]:
    """Which step of each procedure is taken."""
    found = [f"{each.identifier}: {each.step}" for each in recordings if each.step]
    more = f" and {len(found) - _STEPS_NAMED} more" if len(found) > _STEPS_NAMED else ""
    named = "; ".join(found[-_STEPS_NAMED:])
    which = "the last" if step is None else f"that which is named {step!r}"
    return [f"of procedures one step is taken, {which}: {named}{more}"] if found else []


def _clock_notes(points: Sequence[Point]) -> list[str]:
    """Which points have times that passed on no real clock."""
    simulated = sum(point.clock == "simulated" for point in points)
    if not simulated:
        return []
    which = "all points are" if simulated == len(points) else f"{simulated} of {len(points)} points are"
    return [f"{which} in simulated time, which passes at its own pace"]


def _notes(points: Sequence[Point], by_quantity: dict[str, list[ChartedStretch]]) -> list[str]:
    if not points:
        return ["there are no points in that time"]
    notes = _clock_notes(points)
    measured = sum(math.isfinite(point.temperature_c) for point in points)
    if not measured:
        notes.append("no temperature was measured: what it does looks like a change of the specimen")
    elif measured < len(points):
        notes.append(f"{len(points) - measured} points have no temperature and are not held against the others")
    learning = [name for name, parts in by_quantity.items() if not parts[-1].chart.learned.count > LEARNED_FROM]
    if learning:
        notes.append(f"still learning, no change can be seen yet: {', '.join(learning)}")
    for name, parts in by_quantity.items():
        if len(parts) > 1:
            at = points[parts[-1].places[0]].at
            what = f"{len(parts)} kinds of fits, calibrations or fields, a chart for each"
            notes.append(f"{name}: {what}; that of the newest point begins at {at}")
    return notes
