"""A fit of a stored recording as a job; the report is kept on disk."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon import analysis
from platform_daemon.schemas import FitReport, NoResult, RecordingFitRequest, to_json
from platform_daemon.store import write_file
from platform_daemon.workers import Computer

from ..computed import computed
from ..jobs import AnyJob

if TYPE_CHECKING:
    from platform_daemon.analysis import FitSettings


@dataclass(frozen=True)
class FitTask:
    """Fits some frames of a file.  A task for whoever computes."""

    path: Path
    settings: FitSettings
    frames: Sequence[int]

    def __call__(self, tell: Callable[[float, str], None]) -> FitReport:
        """Raises what the file or the settings are not good for."""
        measurement, ask = analysis.open_for_fit(self.path, self.settings)
        report = analysis.fit_measurement(measurement, ask, self.frames, progress=lambda done: tell(done, "fit"))
        return report.model_copy(update={"file": self.path.name})


@dataclass(frozen=True)
class FitWork:
    """Fits some frames of a file; the report is kept in `folder`."""

    request: RecordingFitRequest
    task: FitTask
    folder: Path
    computer: Computer
    kind, unit, no_result = "fit", "frames", NoResult()

    @property
    def total(self) -> int:
        """Frames."""
        return len(self.task.frames)

    def __call__(self, job: AnyJob) -> None:
        """Raises Cancelled, OverBounds, WorkerLost, StorageError."""
        job.result = computed(self.computer, self.kind, self.task, job)
        refused = analysis.why_refused(job.result.frames)
        if refused is not None:
            job.warnings.append(f"every frame was refused: {refused}")
        write_file(self.folder / f"{job.identifier}.json", to_json(job.result, indent=1).encode())
