"""The points of a trend as readings, where the specimen is calibrated as a sensor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.features.measurand.online import newest_calibrations, reading_of
from platform_daemon.features.measurand.schema import MeasurandCalibration

from .charts import SENSED
from .indexed import indexed_specimen
from .schema import TrendChart, TrendMeasurand, TrendPoint, TrendReport


def with_measurand(report: TrendReport, recordings: Path, measurands: Path) -> TrendReport:
    """The report with what each point reads, by the newest calibration of the resonator that it was measured as last.

    recordings, measurands: folders.  Points that cannot be read have no value, and a note says why.  Raises
    UnknownSpecimen, StorageError.
    """
    charts = [chart for chart in report.charts if chart.quantity == SENSED]
    if not charts or not measurands.is_dir():
        return report
    resonator = next(iter(indexed_specimen(recordings, report.specimen).resonators), "")
    made = newest_calibrations(measurands).of(resonator)
    if made is None:
        return report
    values: list[float | None] = []
    expanded: list[float | None] = []
    reasons: dict[str, None] = {}
    for point, f_hz in zip(report.points, charts[0].value, strict=True):
        found = None
        if f_hz is not None:
            at_s = datetime.fromisoformat(point.at).timestamp()
            found = reading_of(made, f_hz, point.temperature_c, at_s, shots=point.shots)
            if found.reason is not None:
                reasons[found.reason] = None
        values.append(None if found is None else found.value)
        expanded.append(None if found is None else found.U)
    told = TrendMeasurand(
        name=made.name,
        unit=made.unit,
        calibration=made.label,
        value=tuple(values),
        U=tuple(expanded),
        **_control_limits(made, charts[0], report.points),
    )
    notes = report.notes
    if reasons:
        unread = sum(value is None for value in values)
        notes = (*notes, f"{unread} of {len(values)} points have no reading; the last reason: {list(reasons)[-1]}")
    return report.model_copy(update={"measurand": told, "notes": notes})


def _control_limits(
    made: MeasurandCalibration, chart: TrendChart, points: Sequence[TrendPoint]
) -> dict[str, tuple[float | None, ...]]:
    """The control chart of the frequency in the unit of the measurand: low is the lower, also where f falls with it."""
    from platform_daemon.features.measurand.sensor import Sensor  # scipy, which a daemon without sensors does not need

    sensor = Sensor.by(made)

    def place(f_hz: float | None, celsius: float | None) -> float | None:
        if f_hz is None or not math.isfinite(f_hz):
            return None
        try:
            return sensor.place(f_hz, celsius)
        except InputError:  # far outside of the calibration
            return None

    columns = (chart.smoothed or (), chart.low or (), chart.high or ())
    smoothed, low, high = [], [], []
    for *at, point in zip(*columns, points, strict=True):
        mean, *ends = (place(f_hz, point.temperature_c) for f_hz in at)
        known = sorted(each for each in ends if each is not None)
        smoothed.append(mean)
        low.append(known[0] if len(known) == 2 else None)
        high.append(known[1] if len(known) == 2 else None)
    return {"smoothed": tuple(smoothed), "low": tuple(low), "high": tuple(high)}
