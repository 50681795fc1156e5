"""Acquisitions as jobs: ask (202), watch, cancel."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Response

from platform_daemon.engine import Job

from ..context import Shared, job_body
from ..models import AcquisitionBody, JobModel, ProblemModel

router = APIRouter(prefix="/acquisitions", tags=["acquisitions"])
ERRORS: dict[int | str, dict[str, Any]] = {404: {"model": ProblemModel}, 422: {"model": ProblemModel}}


def _body(job: Job) -> dict[str, Any]:
    links = {"self": f"/acquisitions/{job.identifier}"}
    if "recording" in job.result:
        links["recording"] = f"/recordings/{job.result['recording']}"
    return job_body(job, links)


@router.post(
    "", summary="Measure a series", status_code=202, response_model=JobModel, responses={422: {"model": ProblemModel}}
)
def start_acquisition(body: AcquisitionBody, response: Response, context: Shared) -> dict[str, Any]:
    """Queue an acquisition.

    Acquisitions run one after the other in the order asked; `state` is `queued` until its turn comes.  The request is
    checked against the safety envelope first: a rejected one is answered 422 and nothing moves.
    """
    plan = context.engine.plan(body)
    job = context.engine.acquire(plan, None, context.recordings)
    response.headers["Location"] = f"/acquisitions/{job.identifier}"
    return _body(job)


@router.post("/dry-run", summary="Check a series without moving anything", responses={422: {"model": ProblemModel}})
def dry_run(body: AcquisitionBody, context: Shared) -> dict[str, Any]:
    """The same checks, nothing moves: realised frequency, currents, voltages, duration, disk, settle check."""
    return context.engine.plan(body).summary()


@router.get("", summary="All acquisitions", response_model=list[JobModel])
def list_acquisitions(context: Shared) -> list[dict[str, Any]]:
    """All acquisitions since the daemon started, oldest first."""
    return [_body(job) for job in context.engine.jobs("acquisition")]


@router.get("/{identifier}", summary="How far it is, and what came out", response_model=JobModel, responses=ERRORS)
def get_acquisition(identifier: str, context: Shared) -> dict[str, Any]:
    """State, progress with time left, and the on-line fits so far."""
    return _body(context.engine.job("acquisition", identifier))


@router.delete("/{identifier}", summary="Cancel", status_code=202, response_model=JobModel, responses=ERRORS)
async def cancel_acquisition(identifier: str, context: Shared) -> dict[str, Any]:
    """Cancel.  A running shot ends within 0.1 s with outputs off and is discarded; shots on disk stay."""
    job = context.engine.job("acquisition", identifier)
    job.request_cancel()
    return _body(job)
