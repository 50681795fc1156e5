"""Acquisitions as jobs: ask (202), watch, cancel."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Query

from drivers.errors import ConfigError
from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.jobs.kinds import job_type
from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.index import resolve
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.acquisitions import AcquisitionResult, AcquisitionSummary, ShotPage, ShotReport
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.state.errors import UnknownRecording
from platform_daemon.core.web.context import CONFIRMED, Confirmed, Context, JobId, Shared
from platform_daemon.core.web.job_routes import JobRoutes
from platform_daemon.core.web.problems import problems

After = Annotated[int, Query(ge=0, le=2**53, description="shots with larger numbers")]
Limit = Annotated[int, Query(ge=1, le=1000, description="at most so many shots")]


def _links(job: JobView) -> dict[str, str]:
    recording = job.result.recording
    here = {"shots": f"/acquisitions/{job.identifier}/shots"}
    return here if recording is None else {**here, "recording": f"/recordings/{recording}"}


ACQUISITIONS = JobRoutes("acquisition", _links)
router = ACQUISITIONS.router()


@router.post("/dry-run", summary="Check a series without moving anything", responses=problems(409, 415, 422, 507))
def dry_run(body: AcquisitionRequest, context: Shared) -> AcquisitionSummary:
    """The same checks, nothing moves: realised frequency, currents, voltages, duration, disk, settle check.

    507 if the disk cannot take it.
    """
    found = context.hardware.dry_run("acquisition", body)
    assert isinstance(found, AcquisitionSummary)
    return found


@router.post(
    "/{identifier}/pause",
    summary="Pause",
    response_model=job_type("acquisition"),
    responses=problems(404, 409, 415),
)
def pause_acquisition(identifier: JobId, context: Shared, body: Confirmed = CONFIRMED) -> Any:
    """Rest between two shots, with outputs off, until it is resumed; one that waits lets others go first."""
    return ACQUISITIONS.shown(context.hardware.pause("acquisition", identifier))


@router.post(
    "/{identifier}/resume",
    summary="Go on",
    status_code=202,
    response_model=job_type("acquisition"),
    responses=problems(404, 409, 415, 422, 507),
)
def resume_acquisition(identifier: JobId, context: Shared, body: Confirmed = CONFIRMED) -> Any:
    """After a pause; or, of a series that was cut off, stopped or failed, with the first shot that is missing.

    The missing shots go into the same recording, which stays as it is until they are there; the first of them is marked
    `joined`.  409 where nothing is missing, 422 where platform, calibration or windows are not those of then.
    """
    return ACQUISITIONS.shown(context.hardware.resume("acquisition", identifier))


@router.get("/{identifier}/shots", summary="Its shots, as they come", responses=problems(404, 422, 423))
def get_shots(identifier: JobId, context: Shared, after: After = 0, limit: Limit = 100) -> ShotPage:
    """Every shot once it is on disk and counts, with its on-line fit once that is there; also while the series runs.

    With each good fit of a resonator that is calibrated as a sensor comes `measurand`, value and U of what it reads.

    Their dm/dt, harmonics and pictures are at `/recordings/{recording}/frames/{frame}`, from the same moment on.
    """
    job = context.hardware.job("acquisition", identifier)
    page = context.hardware.shots("acquisition", identifier, after, limit)
    known = job.result.shots or 0
    if page.items or not known or (not job.state.final and (after >= known or job.record.within is not None)):
        return _read(page, job, context)
    if job.record.within is not None:
        remedy = f"they are in the recording of {job.record.within}"
        raise UnknownId("the shots of this step are not known one by one any more", where=identifier, remedy=remedy)
    try:
        return _read(_stored_shots(job, context, after, limit), job, context)
    except UnknownRecording:
        if job.state.final:
            raise
        return page  # of a series that is made for the first time


def _read(page: ShotPage, job: JobView, context: Context) -> ShotPage:
    """With what the shots read, if their resonator is calibrated as a sensor and the catalogue still has it."""
    from platform_daemon.features.measurand.online import newest_calibrations, with_readings

    if not page.items or not context.folders.measurands.is_dir():
        return page
    try:
        specimen, _ = context.catalogue.resonators.load(job.request.resonator)
    except ConfigError:
        return page
    return with_readings(page, specimen.name, newest_calibrations(context.folders.measurands))


def _stored_shots(job: JobView, context: Context, after: int, limit: int) -> ShotPage:
    """Of a series of an earlier run, or that is resumed.  Raises UnknownRecording, RecordingError."""
    result: AcquisitionResult = job.result
    shots = describe(open_recording(resolve(context.folders.recordings, result.recording or ""))).shots
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
        for each in shots
    )
    return ShotPage.cut(found, job.identifier, after=after, limit=limit)


ACQUISITIONS.add_job_routes(router)
