"""The points of a trend as readings, where the specimen is calibrated as a sensor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.errors import InputError
from platform_daemon.core.schemas.acquisitions import ShotReading
from platform_daemon.features.measurand.online import newest_calibrations, reading_of
from platform_daemon.features.measurand.schema import MeasurandCalibration

from .charts import SENSED
from .indexed import indexed_specimen
from .schema import TrendChart, TrendMeasurand, TrendPoint, TrendReport

if TYPE_CHECKING:
    from platform_daemon.features.measurand.sensor import Sensor

# A reading is propagated anew for every point, 5000 of them in 3 s, and does not change: what a trend showed is kept.
_KEPT_READINGS, _KEPT_PLACES, _KEPT_SENSORS = 10_000, 30_000, 16


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
    calibration = made.model_dump_json()
    values: list[float | None] = []
    expanded: list[float | None] = []
    reasons: dict[str, None] = {}
    for point, f_hz in zip(report.points, charts[0].value, strict=True):
        found = None
        if f_hz is not None:
            at_s = datetime.fromisoformat(point.at).timestamp()
            found = _kept_reading(calibration, f_hz, point.temperature_c, at_s, point.shots)
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
        **_control_limits(calibration, charts[0], report.points),
    )
    notes = report.notes
    if reasons:
        unread = sum(value is None for value in values)
        notes = (*notes, f"{unread} of {len(values)} points have no reading; the last reason: {list(reasons)[-1]}")
    return report.model_copy(update={"measurand": told, "notes": notes})


@lru_cache(maxsize=_KEPT_SENSORS)
def _sensor(calibration: str) -> Sensor:
    """By a calibration as JSON, which is a key, because calibrations cannot be hashed."""
    from platform_daemon.features.measurand.sensor import Sensor  # scipy, which a daemon without sensors does not need

    return Sensor.by(MeasurandCalibration.model_validate_json(calibration))


@lru_cache(maxsize=_KEPT_READINGS)
def _kept_reading(calibration: str, f_hz: float, celsius: float | None, at_s: float, shots: int) -> ShotReading:
    return reading_of(_sensor(calibration).calibration, f_hz, celsius, at_s, shots=shots)


@lru_cache(maxsize=_KEPT_PLACES)
def _kept_place(calibration: str, f_hz: float, celsius: float | None) -> float | None:
    try:
        return _sensor(calibration).place(f_hz, celsius)
    except InputError:  # far outside of the calibration
        return None


def _control_limits(
    calibration: str, chart: TrendChart, points: Sequence[TrendPoint]
) -> dict[str, tuple[float | None, ...]]:
    """The control chart of the frequency in the unit of the measurand: low is the lower, also where f falls with it."""

    def place(f_hz: float | None, celsius: float | None) -> float | None:
        return None if f_hz is None or not math.isfinite(f_hz) else _kept_place(calibration, f_hz, celsius)

    columns = (chart.smoothed or (), chart.low or (), chart.high or ())
    smoothed, low, high = [], [], []
    for *at, point in zip(*columns, points, strict=True):
        mean, *ends = (place(f_hz, point.temperature_c) for f_hz in at)
        known = sorted(each for each in ends if each is not None)
        smoothed.append(mean)
        low.append(known[0] if len(known) == 2 else None)
        high.append(known[1] if len(known) == 2 else None)
    return {"smoothed": tuple(smoothed), "low": tuple(low), "high": tuple(high)}
