"""The trend of a specimen, from what the index holds of its recordings."""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.errors import InputError
from platform_daemon.schemas import TrendPoint, TrendReport
from platform_daemon.store import IndexedRecording

from .changes import changes
from .charts import ChartedStretch, charted, shown
from .points import Point, points_of, quantities
from .prediction import LEARNED_FROM

POINTS_TO_FALSE_ALARM = 20_000.0
"""Of a specimen, unless somebody asks for another number: with four points a day once in fourteen years."""
FEWEST, MOST = 100.0, 1e6


def specimen_trend(
    specimen: str, recordings: Sequence[IndexedRecording], points_to_false_alarm: float = POINTS_TO_FALSE_ALARM
) -> TrendReport:
    """Points, a chart per quantity, and changes with names.

    points_to_false_alarm: mean number of points to an alarm of a specimen that does not change, over all its charts.
    Raises InputError for one outside 100 to 1e6.
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
    return TrendReport(
        specimen=specimen,
        points=tuple(map(_shown, points)),
        charts=tuple(shown(name, parts, points) for name, parts in by_quantity.items()),
        changes=tuple(changes(stretches, points)),
        points_to_false_alarm=points_to_false_alarm,
        notes=tuple(_notes(points, by_quantity)),
    )


def _shown(point: Point) -> TrendPoint:
    measured = math.isfinite(point.temperature_c)
    return TrendPoint(
        at=point.at,
        recording=point.recording,
        shots=point.shots,
        temperature_c=point.temperature_c if measured else None,
    )


def _notes(points: Sequence[Point], by_quantity: dict[str, list[ChartedStretch]]) -> list[str]:
    if not points:
        return ["there are no points in that time"]
    notes = []
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
