"""The points of a trend as readings, where the specimen is calibrated as a sensor."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from platform_daemon.features.measurand.online import newest_calibrations, reading_of

from .indexed import indexed_specimen
from .schema import TrendMeasurand, TrendReport

_READ = "f_nat_hz"


def with_measurand(report: TrendReport, recordings: Path, measurands: Path) -> TrendReport:
    """The report with what each point reads, by the newest calibration of the resonator that it was measured as last.

    recordings, measurands: folders.  Points that cannot be read have no value, and a note says why.  Raises
    UnknownSpecimen, StorageError.
    """
    charts = [chart for chart in report.charts if chart.quantity == _READ]
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
        name=made.name, unit=made.unit, calibration=made.label, value=tuple(values), U=tuple(expanded)
    )
    notes = report.notes
    if reasons:
        unread = sum(value is None for value in values)
        notes = (*notes, f"{unread} of {len(values)} points have no reading; the last reason: {list(reasons)[-1]}")
    return report.model_copy(update={"measurand": told, "notes": notes})
