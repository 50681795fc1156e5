"""A fit of a stored recording as a job; the report is kept on disk."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon.core.jobs.jobs import AnyJob
from platform_daemon.core.jobs.run_task import run_task
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.core.recordings.index import resolve as path_of
from platform_daemon.core.schemas.base import NoResult, to_json
from platform_daemon.core.schemas.fits import FitReport
from platform_daemon.core.service.bench import AnalysisBench
from platform_daemon.core.state.durable import write_file
from platform_daemon.features.models.library import Library

from .request_schema import RecordingFitRequest

if TYPE_CHECKING:
    from .fit_request import FitSettings


@dataclass(frozen=True)
class FitTask:
    """Fits some frames of a file.  A task of the task executor."""

    path: Path
    settings: FitSettings
    frames: Sequence[int]

    def __call__(self, tell: Callable[[float, str], None]) -> FitReport:
        """Raises what the file or the settings are not good for."""
        from platform_daemon.estimation.compilation import COMPILING, is_compiled

        from .fit import fit_measurement
        from .measurement import open_for_fit

        measurement, ask = open_for_fit(self.path, self.settings)
        tell(0.0, "fit" if is_compiled() else COMPILING)
        report = fit_measurement(measurement, ask, self.frames, progress=lambda done: tell(done, "fit"))
        return report.model_copy(update={"file": self.path.name})


@dataclass(frozen=True)
class FitWork:
    """Fits some frames of a file; the report is kept in `folder`."""

    request: RecordingFitRequest
    task: FitTask
    folder: Path
    executor: TaskExecutor
    kind, unit, no_result = "fit", "frames", NoResult()
    duration_s = None

    @property
    def total(self) -> int:
        """Frames."""
        return len(self.task.frames)

    def __call__(self, job: AnyJob) -> None:
        """Raises Cancelled, OverBounds, WorkerLost, StorageError."""
        from .fit_request import without_fit

        job.result = run_task(self.executor, self.kind, self.task, job)
        problem = without_fit(job.result.frames)
        if problem is not None:
            job.warnings.append(": ".join(problem))
        write_file(self.folder / f"{job.identifier}.json", to_json(job.result, indent=1).encode())


def plan(bench: AnalysisBench, request: RecordingFitRequest) -> FitWork:
    """The work of a fit.  Raises InputError for a file, model, window or frame that cannot be."""
    from platform_daemon.features.models.resolve import resolve

    from .fit_request import FitSettings
    from .measurement import open_for_fit, taken_frames

    path = path_of(bench.folders.recordings, request.recording)
    settings = FitSettings(
        model=resolve(request.variant, Library(bench.folders.models)),
        window=request.window,
        fixed=request.fixed or None,
        hold_if_inseparable=request.hints or None,
        terms=tuple(request.terms),
        frames=None if request.frames is None else tuple(request.frames),
        step=request.step,
    )
    measurement, _ = open_for_fit(path, settings)
    frames, _ = taken_frames(measurement, settings.frames, settings.step)
    return FitWork(request, FitTask(path, settings, frames), bench.folders.fits, bench.executor)
