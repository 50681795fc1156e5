"""A fit of a stored recording as a job; the report is kept on disk."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon import analysis
from platform_daemon.schemas import NoResult, RecordingFitRequest, to_json
from platform_daemon.store import write_file

from ..jobs import AnyJob, Cancelled

if TYPE_CHECKING:
    from platform_daemon.analysis import FitRequest, Measurement


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

        report = analysis.fit_measurement(self.measurement, self.ask, self.frames, progress=tell)
        job.result = report.model_copy(update={"file": self.measurement.path.name})
        refused = analysis.why_refused(report.frames)
        if refused is not None:
            job.warnings.append(f"every frame was refused: {refused}")
        write_file(self.folder / f"{job.identifier}.json", to_json(job.result, indent=1).encode())
