"""What a trend says of a temperature that changed while nobody has declared what that does."""

from __future__ import annotations

import math
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.recordings.index import resolve
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.features.budget.declared import declared_in
from platform_daemon.features.budget.thresholds import REMANENCE_PER_K

from .charts import SENSED
from .schema import TrendReport

_LEAST_K = 0.1
"""Change of the temperature over the points from which on it is told: the standard uncertainty of a thermometer that is
read beside the coils, as the shipped platform declares it."""


def undeclared_temperature(report: TrendReport, folder: Path) -> tuple[str, ...]:
    """A note, if the temperature changed and the newest recording in the folder declares no coefficient for f_nat.

    A recording that cannot be read says nothing.
    """
    known = [point.temperature_c for point in report.points if point.temperature_c is not None]
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
    change_k = max(known) - min(known)
    note = (
        f"temperature_coefficient_per_k is not declared for {SENSED}: the temperature changed by {change_k:.2g} K over "
        f"these points, and the frequency perhaps by {abs(REMANENCE_PER_K * values[-1] * change_k):.2g} Hz; no U "
        "contains it. "
    )
    if chart.relative_per_k is None:
        return (note + "The charts have not learned it yet: what looks like a change may be the temperature",)
    return (
        note + f"The chart has learned {chart.relative_per_k * values[-1]:.2g} ± "
        f"{(chart.relative_per_k_std or 0.0) * abs(values[-1]):.1g} Hz/K from the points: declare it, with what is "
        "known from elsewhere",
    )
