"""Calibrations as jobs: ask (202), watch, say that the dipole is turned, cancel; and the files there are."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Response

from drivers.errors import DeviceStateError
from platform_daemon.engine import Job

from ..context import Shared, job_body
from ..models import AdoptionBody, CalibrationBody, InUseModel, JobModel, ProblemModel

router = APIRouter(prefix="/calibrations", tags=["calibrations"])
ERRORS: dict[int | str, dict[str, Any]] = {404: {"model": ProblemModel}, 422: {"model": ProblemModel}}
NO_QUESTION: dict[int | str, dict[str, Any]] = {404: {"model": ProblemModel}, 409: {"model": ProblemModel}}


def _body(job: Job) -> dict[str, Any]:
    links = {"self": f"/calibrations/{job.identifier}"}
    if job.question is not None:
        links["continue"] = f"/calibrations/{job.identifier}/continue"
    return {**job_body(job, links), "question": job.question}


class CalibrationJobModel(JobModel):
    """A calibration; `question`: what the operator has to do before it goes on, null: nothing."""

    question: str | None


@router.post(
    "",
    summary="Calibrate the receive or the transmit side",
    status_code=202,
    response_model=CalibrationJobModel,
    responses={422: {"model": ProblemModel}},
)
def start_calibration(body: CalibrationBody, response: Response, context: Shared) -> dict[str, Any]:
    """Queue a calibration.

    It waits its turn among the acquisitions and writes a new version of its file.  The daemon goes on with the
    calibration it has until it is told to use this one: POST /calibrations/adopt.
    """
    job = context.engine.calibrate(body, context.calibrations)
    response.headers["Location"] = f"/calibrations/{job.identifier}"
    return _body(job)


@router.post(
    "/adopt",
    summary="Use a calibration from the next series on",
    response_model=InUseModel,
    responses={409: {"model": ProblemModel}, 422: {"model": ProblemModel}},
)
def adopt_calibration(body: AdoptionBody, context: Shared) -> dict[str, Any]:
    """Use a calibration that a job has written, or read the file that the platform file names anew.

    It holds until the daemon ends: name it in the platform file to keep it.  409 while a series or a calibration runs
    or waits.
    """
    return context.engine.activate(body, context.calibrations)


@router.get("", summary="All calibrations", response_model=list[CalibrationJobModel])
def list_calibrations(context: Shared) -> list[dict[str, Any]]:
    """All calibrations since the daemon's data folder began, oldest first."""
    return [_body(job) for job in context.engine.jobs("calibration")]


@router.get(
    "/{identifier}", summary="How far it is, and what it found", response_model=CalibrationJobModel, responses=ERRORS
)
def get_calibration(identifier: str, context: Shared) -> dict[str, Any]:
    """State, progress, the operator's part if there is one, and the result."""
    return _body(context.engine.job("calibration", identifier))


@router.post(
    "/{identifier}/continue",
    summary="What was asked of the operator is done",
    response_model=CalibrationJobModel,
    responses=NO_QUESTION,
)
def continue_calibration(identifier: str, context: Shared) -> dict[str, Any]:
    """The reference dipole is turned, or the probe is in its place: go on."""
    job = context.engine.job("calibration", identifier)
    if job.question is None:
        raise DeviceStateError("the calibration does not wait for anything", where=identifier, remedy="look at `state`")
    job.proceed.set()
    return _body(job)


@router.delete("/{identifier}", summary="Cancel", status_code=202, response_model=CalibrationJobModel, responses=ERRORS)
async def cancel_calibration(identifier: str, context: Shared) -> dict[str, Any]:
    """Cancel.  A running shot ends within 0.1 s with outputs off; no file is written."""
    job = context.engine.job("calibration", identifier)
    job.request_cancel()
    return _body(job)
