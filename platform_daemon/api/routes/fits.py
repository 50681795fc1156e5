"""Fits of stored recordings as jobs; results are kept on disk."""

from __future__ import annotations

from fastapi import APIRouter, Response

from platform_daemon.analysis import FitSettings, chosen_frames, open_for_fit, resolve
from platform_daemon.engine import FitTask, FitWork
from platform_daemon.link import ShownJob
from platform_daemon.schemas import FitJob, FitJobs, RecordingFitRequest
from platform_daemon.store import resolve as path_of

from ..context import Shared
from ..job_routes import JobKind
from ..network.routes import GuardedRoute
from ..problems import problems

router = APIRouter(prefix="/fits", tags=["fits"], route_class=GuardedRoute)
FITS = JobKind(
    "fit",
    "fits",
    FitJob,
    FitJobs,
    lambda job: {"recording": f"/recordings/{job.request.recording}"},
    got="State, progress, and the result once it is there.",
    cancelled="Cancel after the frame under way.",
)


@router.post("", summary="Fit a recording", status_code=202, responses=problems(404, 415, 422, 503, 507))
def start_fit(body: RecordingFitRequest, response: Response, context: Shared) -> FitJob:
    """Fit an angle file, or every excited frame of a recording, or of those in `frames`.

    `result` is the same object that `platform-daemon fit --json` writes.
    """
    path = path_of(context.recordings, body.recording)
    settings = FitSettings(
        model=resolve(body.variant, context.models),
        window=body.window,
        fixed=body.fixed or None,
        hold_if_inseparable=body.hints or None,
        terms=tuple(body.terms),
    )
    measurement, _ = open_for_fit(path, settings)
    frames = chosen_frames(measurement, body.frames)

    job = context.analyses.analyse(
        FitWork(body, FitTask(path, settings, frames), context.fits, context.analyses.computer)
    )
    return FITS.accepted(ShownJob.of(job), response)


FITS.add_routes(router)
