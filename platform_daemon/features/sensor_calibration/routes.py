"""Calibrating a resonator as a sensor."""

from __future__ import annotations

import hashlib
from contextlib import suppress
from pathlib import Path

from fastapi import APIRouter, Response

from drivers.errors import RecordingError
from platform_daemon.core.jobs.workers.task_executor import Call
from platform_daemon.core.recordings.index import resolve
from platform_daemon.core.schemas.fits import FileDigest
from platform_daemon.core.web.context import Context, Shared
from platform_daemon.core.web.costs import check_file
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.problems import OWNER, problems
from platform_daemon.features.measurand.library import Measurands
from platform_daemon.features.measurand.schema import MeasurandCalibration
from platform_daemon.features.schedules.routes import schedules

from .schema import MeasurandRequest
from .series import Series, series_of
from .stored import calibration_by

router = APIRouter(tags=["measurands"], route_class=GuardedRoute)


@router.post(
    "/measurands",
    summary="Calibrate a resonator as a sensor",
    status_code=201,
    responses=problems(404, 413, 415, 422, 507, *OWNER),
)
def calibrate_measurand(body: MeasurandRequest, response: Response, context: Shared) -> MeasurandCalibration:
    """Pair shots and readings of a reference by time, fit with errors in both, and keep the next version.

    What it is made of are the recordings of a schedule that are of this resonator, or those that are named.
    """
    # numpy, which a daemon without sensors does not need
    from platform_daemon.features.measurand.reference_file import reference_from
    from platform_daemon.features.measurand.work import declared_measurand

    specimen = context.catalogue.resonators.named(body.specimen)
    measurand = declared_measurand(specimen, body.specimen)
    reference = None
    if body.reference is not None:
        data = body.reference.encode()
        digest = FileDigest(file="reference", size_bytes=len(data), sha256=hashlib.sha256(data).hexdigest())
        reference = reference_from(body.reference, "reference", measurand), digest
    library = Measurands(context.folders.measurands)
    before = {"before": library.newest_of(specimen.name)}
    made = context.run(Call(calibration_by, (specimen, _given(body, context), reference), before))
    kept = library.add(made)
    response.headers["Location"] = f"/measurands/{kept.label}"
    return kept


def _given(body: MeasurandRequest, context: Context) -> Series | tuple[Path, ...]:
    folder = context.folders.recordings
    if body.schedule is not None:
        series = series_of(schedules(context), body.schedule, folder, body.since, body.until)
        for path in series.files:
            with suppress(RecordingError):  # what cannot be read is left out, and the calibration tells it
                check_file(path)
        return series
    given = tuple(resolve(folder, each) for each in body.recordings or ())
    for path in given:
        check_file(path)
    return given
