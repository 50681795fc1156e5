"""Calibrations as jobs: ask (202), watch, say that the dipole is turned, cancel; and the files there are."""

from __future__ import annotations

from fastapi import APIRouter, Response

from platform_daemon.link import ShownJob
from platform_daemon.schemas import (
    ActivationRequest,
    CalibrationJob,
    CalibrationJobs,
    CalibrationRequest,
    CalibrationsInUse,
)

from ..context import CONFIRMED, Confirmed, JobId, Shared
from ..job_routes import JobKind
from ..network.routes import GuardedRoute
from ..problems import OWNER, problems

router = APIRouter(prefix="/calibrations", tags=["calibrations"], route_class=GuardedRoute, responses=problems(*OWNER))


def _links(job: ShownJob) -> dict[str, str]:
    return {} if job.question is None else {"continue": f"/calibrations/{job.identifier}/continue"}


CALIBRATIONS = JobKind(
    "calibration",
    "calibrations",
    CalibrationJob,
    CalibrationJobs,
    _links,
    got="State, progress, the operator's part if there is one, and the result.",
    cancelled="Cancel.  A running shot ends within 0.1 s with outputs off; no file is written.",
)


@router.post(
    "",
    summary="Calibrate the receive or the transmit side",
    status_code=202,
    responses=problems(409, 415, 422, 507),
)
def start_calibration(body: CalibrationRequest, response: Response, context: Shared) -> CalibrationJob:
    """Queue a calibration.

    It waits its turn among the acquisitions and writes a new version of its file.  The daemon goes on with the
    calibration it has until it is told to use this one: POST /calibrations/adopt.
    """
    return CALIBRATIONS.accepted(context.hardware.calibrate(body), response)


@router.post("/adopt", summary="Use a calibration from the next series on", responses=problems(409, 415, 422))
def adopt_calibration(body: ActivationRequest, context: Shared) -> CalibrationsInUse:
    """Use a calibration that a job has written, or read the file that the platform file names anew.

    It holds until the daemon ends: name it in the platform file to keep it.  409 while a series or a calibration runs
    or waits.
    """
    return context.hardware.activate(body)


@router.put("/{identifier}", summary="Change what has not begun", responses=problems(404, 409, 415, 422, 507))
def edit_calibration(identifier: JobId, body: CalibrationRequest, context: Shared) -> CalibrationJob:
    """Another request in the place of that of a calibration that waits; 409 once it has begun."""
    return CALIBRATIONS.shown(context.hardware.edit("calibration", identifier, body))


CALIBRATIONS.add_routes(router)


@router.post(
    "/{identifier}/continue", summary="What was asked of the operator is done", responses=problems(404, 409, 415, 422)
)
def continue_calibration(identifier: JobId, context: Shared, body: Confirmed = CONFIRMED) -> CalibrationJob:
    """The reference dipole is turned, or the probe is in its place: go on."""
    return CALIBRATIONS.shown(context.hardware.answer("calibration", identifier))
