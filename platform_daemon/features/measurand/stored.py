"""The readings of a stored recording, as a function of what can be sent to another process."""

from __future__ import annotations

from pathlib import Path

from drivers.errors import InputError

from .library import Measurands
from .schema import MeasurandReport


def stored_readings(
    path: Path, folder: Path, calibration: str | None, coverage: float, extrapolate: bool
) -> MeasurandReport:
    """By KEY or KEY@VERSION of the calibrations in `folder`; None: the newest of the specimen that the file names.

    Raises InputError, RecordingError.
    """
    # Here, because the process that sends it needs none of it: numba and scipy take 0.7 s of a processor to load.
    from platform_daemon.features.fit.fit_request import FitSettings
    from platform_daemon.features.fit.known_moment import declared_specimen
    from platform_daemon.features.fit.measurement import VoltageMeasurement, open_shots_for_fit

    from .sensor import report_of
    from .shots import shots_of

    measurement, ask = open_shots_for_fit(path, FitSettings(None, "d30"))
    kept = Measurands(folder)
    if calibration is not None:
        made = kept.get(calibration)
    else:
        recording = measurement.recording if isinstance(measurement, VoltageMeasurement) else None
        specimen = None if recording is None or recording.provenance is None else declared_specimen(recording)
        if specimen is None:
            remedy = "name the calibration"
            raise InputError("the recording does not say of which specimen it is", where=str(path), remedy=remedy)
        made = kept.of_specimen(specimen.name)
    return report_of(path.name, shots_of(measurement, ask), made, coverage=coverage, extrapolate=extrapolate)
