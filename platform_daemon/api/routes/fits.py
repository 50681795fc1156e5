"""Fits of stored recordings as jobs; results are kept on disk."""

from __future__ import annotations

from fastapi import APIRouter, Response

from platform_daemon.link import ShownJob
from platform_daemon.schemas import FitJob, FitJobs, RecordingFitRequest

from ..context import Shared
from ..job_routes import JobKind
from ..network.routes import GuardedRoute
from ..problems import problems
from ..stored_work import fit_work

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
    return FITS.accepted(ShownJob.of(context.analyses.analyse(fit_work(body, context))), response)


FITS.add_routes(router)
