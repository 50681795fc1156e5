"""Fits of stored recordings as jobs; results are kept on disk."""

from __future__ import annotations

from fastapi import APIRouter, Response

from platform_daemon.analysis import (
    FitRequest,
    angle_variant,
    angles_report,
    check_fixed,
    choose_variant,
    chosen_frames,
    fit_angles,
    fit_recording,
    resolve,
    why_refused,
)
from platform_daemon.engine import AnyJob, Cancelled, Job
from platform_daemon.schemas import FitJob, FitJobs, FitReport, NoResult, RecordingFitRequest, to_json
from platform_daemon.store import AngleSeries, Recording, is_time_series, open_recording, read_angles, write_whole
from platform_daemon.store import resolve as path_of

from ..context import Shared
from ..job_routes import JobKind
from ..problems import problems

router = APIRouter(prefix="/fits", tags=["fits"])
FITS = JobKind(
    "fit",
    "fits",
    FitJob,
    FitJobs,
    lambda job: {"recording": f"/recordings/{job.request.recording}"},
    got="State, progress, and the result once it is there.",
    cancelled="Cancel after the frame under way.",
)


@router.post("", summary="Fit a recording", status_code=202, responses=problems(404, 409, 415, 422, 507))
def start_fit(body: RecordingFitRequest, response: Response, context: Shared) -> FitJob:
    """Fit an angle file, or every excited frame of a recording, or of those in `frames`.

    `result` is the same object that `platform-daemon fit --json` writes.
    """
    recording, ask = _asked(body, context)
    frames = chosen_frames(recording, body.frames)

    def work(job: AnyJob) -> None:
        def tell(frames: int) -> None:
            job.at(frames, "fit")
            if job.cancel_requested.is_set():
                raise Cancelled

        if isinstance(recording, AngleSeries):
            found = angles_report(recording, ask, [fit_angles(recording, ask)])
        else:
            found = fit_recording(recording, ask, frames, progress=tell)
        job.result = FitReport.model_validate({**found, "file": recording.path.name})
        refused = why_refused(found["frames"])
        if refused is not None:
            job.warnings.append(f"every frame was refused: {refused}")
        write_whole(context.fits / f"{job.identifier}.json", to_json(job.result, indent=1).encode())

    job: AnyJob = Job("fit", body, NoResult(), len(frames), "frames")
    context.engine.analyse(job, work)
    return FITS.accepted(job, response)


def _asked(body: RecordingFitRequest, context: Shared) -> tuple[Recording | AngleSeries, FitRequest]:
    """What is to be fitted, and how.  Raises InputError."""
    wanted, path = resolve(body.variant, context.models), path_of(context.recordings, body.recording)
    recording: Recording | AngleSeries
    if is_time_series(path):
        recording = read_angles(path)
        variant, calibrated = angle_variant(recording, wanted, body.terms), False
    else:
        recording, variant = choose_variant(open_recording(path), wanted, body.terms)
        calibrated = recording.calibration is not None
    ask = FitRequest(variant, body.window, body.fixed or None, body.hints or None)
    check_fixed(ask, calibrated=calibrated)
    return recording, ask


FITS.add_routes(router)
