"""Acquisitions as jobs: ask (202), watch, cancel."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Response

from platform_daemon.engine import UnknownId
from platform_daemon.link import ShownJob
from platform_daemon.schemas import (
    AcquisitionJob,
    AcquisitionJobs,
    AcquisitionRequest,
    AcquisitionResult,
    AcquisitionSummary,
    ShotPage,
    ShotReport,
)
from platform_daemon.store import UnknownRecording, describe

from ..context import CONFIRMED, Confirmed, Context, JobId, Shared
from ..job_routes import JobKind
from ..network.routes import GuardedRoute
from ..problems import OWNER, problems
from .recordings import opened

router = APIRouter(prefix="/acquisitions", tags=["acquisitions"], route_class=GuardedRoute, responses=problems(*OWNER))

After = Annotated[int, Query(ge=0, le=2**53, description="shots with larger numbers")]
Limit = Annotated[int, Query(ge=1, le=1000, description="at most so many shots")]


def _links(job: ShownJob) -> dict[str, str]:
    recording = job.result.recording
    here = {"shots": f"/acquisitions/{job.identifier}/shots"}
    return here if recording is None else {**here, "recording": f"/recordings/{recording}"}


ACQUISITIONS = JobKind(
    "acquisition",
    "acquisitions",
    AcquisitionJob,
    AcquisitionJobs,
    _links,
    got="State, progress with time left, and the on-line fits so far.",
    cancelled="Cancel.  A running shot ends within 0.1 s with outputs off and is discarded; shots on disk stay.",
)


@router.post("", summary="Measure a series", status_code=202, responses=problems(409, 415, 422, 507))
def start_acquisition(body: AcquisitionRequest, response: Response, context: Shared) -> AcquisitionJob:
    """Queue an acquisition.

    Acquisitions run one after the other in the order asked; `state` is `queued` until its turn comes.  The request is
    checked against the safety envelope first: a rejected one is answered 422 and nothing moves.
    """
    return ACQUISITIONS.accepted(context.hardware.acquire(body), response)


@router.post("/dry-run", summary="Check a series without moving anything", responses=problems(409, 415, 422, 507))
def dry_run(body: AcquisitionRequest, context: Shared) -> AcquisitionSummary:
    """The same checks, nothing moves: realised frequency, currents, voltages, duration, disk, settle check.

    507 if the disk cannot take it.
    """
    return context.hardware.dry_run(body)


@router.put("/{identifier}", summary="Change what has not begun", responses=problems(404, 409, 415, 422, 507))
def edit_acquisition(identifier: JobId, body: AcquisitionRequest, context: Shared) -> AcquisitionJob:
    """Another request in the place of that of an acquisition that waits; 409 once it has begun."""
    return ACQUISITIONS.shown(context.hardware.edit("acquisition", identifier, body))


@router.post("/{identifier}/pause", summary="Pause", responses=problems(404, 409, 415))
def pause_acquisition(identifier: JobId, context: Shared, body: Confirmed = CONFIRMED) -> AcquisitionJob:
    """Rest between two shots, with outputs off, until it is resumed; one that waits lets others go first."""
    return ACQUISITIONS.shown(context.hardware.pause("acquisition", identifier))


@router.post("/{identifier}/resume", summary="Go on", status_code=202, responses=problems(404, 409, 415, 422, 507))
def resume_acquisition(identifier: JobId, context: Shared, body: Confirmed = CONFIRMED) -> AcquisitionJob:
    """After a pause; or, of a series that was cut off, stopped or failed, with the first shot that is missing.

    The missing shots go into the same recording, which stays as it is until they are there; the first of them is marked
    `joined`.  409 where nothing is missing, 422 where platform, calibration or windows are not those of then.
    """
    return ACQUISITIONS.shown(context.hardware.resume("acquisition", identifier))


@router.get("/{identifier}/shots", summary="Its shots, as they come", responses=problems(404, 422))
def get_shots(identifier: JobId, context: Shared, after: After = 0, limit: Limit = 100) -> ShotPage:
    """Every shot once it is on disk and counts, with its on-line fit once that is there; also while the series runs.

    Their dm/dt, harmonics and pictures are at `/recordings/{recording}/frames/{frame}`, from the same moment on.
    """
    job = context.hardware.job("acquisition", identifier)
    page = context.hardware.shots(identifier, after, limit)
    known = job.result.shots or 0
    if page.shots or not known or (not job.state.final and (after >= known or job.record.within is not None)):
        return page
    if job.record.within is not None:
        remedy = f"they are in the recording of {job.record.within}"
        raise UnknownId("the shots of this step are not known one by one any more", where=identifier, remedy=remedy)
    try:
        return _stored_shots(job.result, context, after, limit)
    except UnknownRecording:
        if job.state.final:
            raise
        return page  # of a series that is made for the first time


def _stored_shots(result: AcquisitionResult, context: Context, after: int, limit: int) -> ShotPage:
    """Of a series of an earlier run, or that is gone on with.  Raises UnknownRecording, RecordingError."""
    shots = describe(opened(result.recording or "", context)).shots
    fits = {} if result.fit is None else {each.frame: each for each in result.fit.frames}
    found = tuple(
        ShotReport(
            shot=each.frame + 1,
            frame=each.frame,
            time_stamp=each.time_stamp,
            blank=each.blank,
            verdict="good" if each.verdict == "good" else "refused",
            reason=each.reason or None,
            temperature_c=each.temperature_c,
            fit=fits.get(each.frame),
        )
        for each in shots[after : after + limit]
    )
    return ShotPage(shots=found, more=after + limit < len(shots))


ACQUISITIONS.add_routes(router)
