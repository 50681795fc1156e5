"""Fits of stored recordings as jobs; results are kept on disk."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Response

from platform_daemon.analysis import FitSettings, chosen_frames, fit_measurement, open_for_fit, resolve, why_refused
from platform_daemon.engine import Cancelled, Job
from platform_daemon.schemas import to_json
from platform_daemon.store import resolve as path_of
from platform_daemon.store import write_file

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
    path = path_of(context.recordings, body.recording)
    settings = FitSettings(
        variant=resolve(body.variant, context.models),
        window=body.window,
        fixed=body.fixed or None,
        hold_if_inseparable=body.hints or None,
        terms=tuple(body.terms),
    )
    measurement, ask = open_for_fit(path, settings)
    frames = chosen_frames(measurement, body.frames)

    def work(job: Job) -> None:
        def tell(frames: int) -> None:
            job.at(frames, "fit")
            if job.cancel_requested.is_set():
                raise Cancelled

        report = fit_measurement(measurement, ask, frames, progress=tell).model_copy(update={"file": path.name})
        job.result = report.model_dump()
        refused = why_refused(report.frames)
        if refused is not None:
            job.warnings.append(f"every frame was refused: {refused}")
        write_file(context.fits / f"{job.identifier}.json", to_json(report, indent=1).encode())

    job = context.engine.analyse(body.model_dump(mode="json"), len(frames), work)
    response.headers["Location"] = f"/fits/{job.identifier}"
    return _body(job)


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
