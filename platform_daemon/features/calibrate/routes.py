"""Calibrations as jobs: ask (202), watch, say that the dipole is turned, cancel; and the files there are."""

from __future__ import annotations

from typing import Any

from platform_daemon.core.jobs.kinds import job_type
from platform_daemon.core.schemas.calibrations import CalibrationsInUse
from platform_daemon.core.schemas.requests import ActivationRequest
from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.web.context import CONFIRMED, Confirmed, JobId, Shared
from platform_daemon.core.web.job_routes import JobRoutes
from platform_daemon.core.web.problems import problems


def _links(job: JobView) -> dict[str, str]:
    return {} if job.question is None else {"continue": f"/calibrations/{job.identifier}/continue"}


CALIBRATIONS = JobRoutes("calibration", _links)
router = CALIBRATIONS.router()


@router.post("/adopt", summary="Use a calibration from the next series on", responses=problems(409, 415, 422, 423))
def adopt_calibration(body: ActivationRequest, context: Shared) -> CalibrationsInUse:
    """Use a calibration that a job has written, or read the file that the platform file names again.

    It holds until the daemon ends: name it in the platform file to keep it.  409 while a series or a calibration runs
    or waits.
    """
    return context.hardware.activate(body)


CALIBRATIONS.add_job_routes(router)


@router.post(
    "/{identifier}/continue",
    summary="Report that the operator's step is done",
    response_model=job_type("calibration"),
    responses=problems(404, 409, 415, 422),
)
def continue_calibration(identifier: JobId, context: Shared, body: Confirmed = CONFIRMED) -> Any:
    """Report that the reference dipole is turned, or the probe in its place; the job continues."""
    return CALIBRATIONS.shown(context.hardware.answer("calibration", identifier))
