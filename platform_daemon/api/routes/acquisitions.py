"""Acquisitions as jobs: ask (202), watch, cancel."""

from __future__ import annotations

from fastapi import APIRouter, Response

from platform_daemon.link import ShownJob
from platform_daemon.schemas import AcquisitionJob, AcquisitionJobs, AcquisitionRequest, AcquisitionSummary

from ..context import Shared
from ..job_routes import JobKind
from ..network.routes import GuardedRoute
from ..problems import problems

router = APIRouter(prefix="/acquisitions", tags=["acquisitions"], route_class=GuardedRoute)


def _links(job: ShownJob) -> dict[str, str]:
    recording = job.result.recording
    return {} if recording is None else {"recording": f"/recordings/{recording}"}


ACQUISITIONS = JobKind(
    "acquisition",
    "acquisitions",
    AcquisitionJob,
    AcquisitionJobs,
    _links,
    got="State, progress with time left, and the on-line fits so far.",
    cancelled="Cancel.  A running shot ends within 0.1 s with outputs off and is discarded; shots on disk stay.",
)


@router.post("", summary="Measure a series", status_code=202, responses=problems(409, 415, 422, 503, 507))
def start_acquisition(body: AcquisitionRequest, response: Response, context: Shared) -> AcquisitionJob:
    """Queue an acquisition.

    Acquisitions run one after the other in the order asked; `state` is `queued` until its turn comes.  The request is
    checked against the safety envelope first: a rejected one is answered 422 and nothing moves.
    """
    return ACQUISITIONS.accepted(context.hardware.acquire(body), response)


@router.post("/dry-run", summary="Check a series without moving anything", responses=problems(415, 422, 507))
def dry_run(body: AcquisitionRequest, context: Shared) -> AcquisitionSummary:
    """The same checks, nothing moves: realised frequency, currents, voltages, duration, disk, settle check.

    507 if the disk cannot take it.
    """
    return context.hardware.dry_run(body)


ACQUISITIONS.add_routes(router)
