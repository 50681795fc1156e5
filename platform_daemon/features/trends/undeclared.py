"""What a trend says of a temperature that changed while nobody has declared what that does."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.recordings.index import resolve
from platform_daemon.core.recordings.indexed import IndexedRecording
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.features.budget.declared import declared_in
from platform_daemon.features.budget.thresholds import REMANENCE_PER_K

from .charts import SENSED
from .schema import TrendReport

_LEAST_K = 0.1
"""Change of the temperature over the points from which on it is told: the standard uncertainty of a thermometer that is
read beside the coils, as the shipped platform declares it."""


_KNOWN_SD = 3.0
"""Standard deviations from which on what a chart has learned is told as known: chance makes as much in 0.3 %."""


def undeclared_temperature(
    report: TrendReport, recordings: Sequence[IndexedRecording], folder: Path
) -> tuple[str, ...]:
    """A note, if the temperature changed and the newest recording in the folder declares no coefficient for f_nat.

    recordings: of all points, also of those that the report does not list.  One that cannot be read says nothing.
    """
    known = [p.temperature_c for each in recordings for p in each.points if p.temperature_c is not None]
    chart = next((each for each in report.charts if each.quantity == SENSED), None)
    values = [] if chart is None else [value for value in chart.value if value is not None and math.isfinite(value)]
    if not values or chart is None or len(known) < 2 or max(known) - min(known) < _LEAST_K:
        return ()
    try:
        declared = declared_in(open_recording(resolve(folder, report.points[-1].recording)))
    except InputError:
        return ()
    if SENSED in declared.temperature_coefficient_per_k:
        return ()
    change_k, f_hz = max(known) - min(known), values[-1]
    note = (
        f"temperature_coefficient_per_k is not declared for {SENSED}: the temperature changed by {change_k:.2g} K over "
        f"all points, and the frequency perhaps by {abs(REMANENCE_PER_K * f_hz * change_k):.2g} Hz; no U contains it. "
    )
    slope, std = chart.relative_per_k, chart.relative_per_k_std
    if slope is None or not std or abs(slope) < _KNOWN_SD * std:
        return (note + "The charts do not know it yet: what looks like a change may be the temperature",)
    learned = f"{slope * f_hz:.2g} ± {std * f_hz:.1g} Hz/K"
    return (note + f"The chart has learned {learned}: declare it, if nothing is known from elsewhere",)
