"""Rows of a ledger as readings, where what was recorded is of a resonator that is calibrated as a sensor."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from datetime import datetime
from pathlib import Path
from statistics import fmean

import structlog

from platform_daemon.core.recordings.indexed import IndexedShot
from platform_daemon.core.recordings.recording_index import open_index
from platform_daemon.core.schemas.acquisitions import ShotReading
from platform_daemon.core.state.errors import StorageError
from platform_daemon.features.measurand.online import newest_calibrations, reading_of
from platform_daemon.features.measurand.schema import MeasurandCalibration

from .schema import LedgerPage

log = structlog.get_logger()
_READ = "f_nat_hz"


def with_readings(page: LedgerPage, recordings: Path, measurands: Path) -> LedgerPage:
    """The page with what each recording reads by the newest calibration of its resonator, from the mean of its shots.

    recordings, measurands: folders.  A row stays as it is while the index does not know its recording.
    """
    names = {row.recording for row in page.items if row.recording is not None}
    if not names or not measurands.is_dir():
        return page
    calibrations = newest_calibrations(measurands)
    told: dict[str, ShotReading] = {}
    try:
        with closing(open_index(recordings)) as index:
            for name, summary in index.summaries(sorted(names)).items():
                made = None if summary.resonator is None else calibrations.of(summary.resonator)
                shots = [] if made is None else [each for each in index.shots(name) if _READ in each.values]
                # f_nat goes with the amplitude: shots in several fields are no repeats of one reading.
                if made is not None and len({each.field_t for each in shots}) == 1:
                    told[name] = _mean_reading(made, shots)
    except StorageError as error:  # the ledger does not depend on the index
        log.warning("ledger_without_readings", error=str(error))
        return page
    items = (
        row if row.recording not in told else row.model_copy(update={"measurand": told[row.recording]})
        for row in page.items
    )
    return page.model_copy(update={"items": tuple(items)})


def _mean_reading(made: MeasurandCalibration, shots: Sequence[IndexedShot]) -> ShotReading:
    known = [each.temperature_c for each in shots if each.temperature_c is not None]
    celsius = fmean(known) if len(known) == len(shots) else None
    f_hz, at_s = fmean(each.values[_READ] for each in shots), datetime.fromisoformat(shots[0].at).timestamp()
    return reading_of(made, f_hz, celsius, at_s, shots=len(shots))
