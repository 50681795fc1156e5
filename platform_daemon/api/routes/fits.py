"""Fits of stored recordings as jobs; results are kept on disk."""

from __future__ import annotations

import json
from typing import Any

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
from platform_daemon.engine import Cancelled, Job
from platform_daemon.store import AngleSeries, Recording, is_time_series, open_recording, read_angles, write_file
from platform_daemon.store import resolve as path_of

from ..context import Shared, job_body
from ..models import FitBody, JobModel, ProblemModel

router = APIRouter(prefix="/fits", tags=["fits"])
ERRORS: dict[int | str, dict[str, Any]] = {404: {"model": ProblemModel}, 422: {"model": ProblemModel}}


def _body(job: Job) -> dict[str, Any]:
    return job_body(job, {"self": f"/fits/{job.identifier}", "recording": f"/recordings/{job.request['recording']}"})


@router.post("", summary="Fit a recording", status_code=202, response_model=JobModel, responses=ERRORS)
def start_fit(body: FitBody, response: Response, context: Shared) -> dict[str, Any]:
    """Fit an angle file, or every excited frame of a recording, or of those in `frames`.

    `result` is the same object that `platform-daemon fit --json` writes.
    """
    recording, ask = _asked(body, context)
    frames = chosen_frames(recording, body.frames)

    def work(job: Job) -> None:
        def tell(frames: int) -> None:
            job.at(frames, "fit")
            if job.cancel_requested.is_set():
                raise Cancelled

        if isinstance(recording, AngleSeries):
            found = angles_report(recording, ask, [fit_angles(recording, ask)])
        else:
            found = fit_recording(recording, ask, frames, progress=tell)
        job.result = {**found, "file": recording.path.name}
        refused = why_refused(job.result["frames"])
        if refused is not None:
            job.warnings.append(f"every frame was refused: {refused}")
        write_file(context.fits / f"{job.identifier}.json", json.dumps(job.result, indent=1).encode())

    job = context.engine.analyse(body.model_dump(mode="json"), len(frames), work)
    response.headers["Location"] = f"/fits/{job.identifier}"
    return _body(job)


def _asked(body: FitBody, context: Shared) -> tuple[Recording | AngleSeries, FitRequest]:
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


@router.get("", summary="All fits", response_model=list[JobModel])
def list_fits(context: Shared) -> list[dict[str, Any]]:
    """All fits asked for since the daemon started, oldest first."""
    return [_body(job) for job in context.engine.jobs("fit")]


@router.get("/{identifier}", summary="How far it is, and the result", response_model=JobModel, responses=ERRORS)
def get_fit(identifier: str, context: Shared) -> dict[str, Any]:
    """State, progress, and the result once it is there."""
    return _body(context.engine.job("fit", identifier))


@router.delete("/{identifier}", summary="Cancel", status_code=202, response_model=JobModel, responses=ERRORS)
def cancel_fit(identifier: str, context: Shared) -> dict[str, Any]:
    """Cancel after the frame under way."""
    job = context.engine.job("fit", identifier)
    job.request_cancel()
    return _body(job)
