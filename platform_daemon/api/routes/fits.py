"""Fits of stored recordings as jobs; results are kept on disk."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fastapi import APIRouter, Response

from platform_daemon.analysis import (
    FitRequest,
    FitSettings,
    Measurement,
    chosen_frames,
    fit_measurement,
    open_for_fit,
    resolve,
    why_refused,
)
from platform_daemon.engine import AnyJob, Cancelled
from platform_daemon.schemas import FitJob, FitJobs, NoResult, RecordingFitRequest, to_json
from platform_daemon.store import resolve as path_of
from platform_daemon.store import write_file

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


@dataclass(frozen=True)
class FitWork:
    """Fits some frames of a file; the report is kept in `folder`."""

    request: RecordingFitRequest
    measurement: Measurement
    ask: FitRequest
    frames: Sequence[int]
    folder: Path
    kind, unit, no_result = "fit", "frames", NoResult()

    @property
    def total(self) -> int:
        """Frames."""
        return len(self.frames)

    def __call__(self, job: AnyJob) -> None:
        """Raises Cancelled between frames, StorageError."""

        def tell(frames: int) -> None:
            job.at(frames, "fit")
            if job.cancel_requested.is_set():
                raise Cancelled

        report = fit_measurement(self.measurement, self.ask, self.frames, progress=tell)
        job.result = report.model_copy(update={"file": self.measurement.path.name})
        refused = why_refused(report.frames)
        if refused is not None:
            job.warnings.append(f"every frame was refused: {refused}")
        write_file(self.folder / f"{job.identifier}.json", to_json(job.result, indent=1).encode())


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
    measurement, ask = open_for_fit(path, settings)
    frames = chosen_frames(measurement, body.frames)

    job = context.engine.analyse(FitWork(body, measurement, ask, frames, context.fits))
    return FITS.accepted(job, response)


FITS.add_routes(router)
