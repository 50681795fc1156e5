"""A diagnosis of stored recordings as a job; report and page are kept on disk."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon import analysis, diagnosis
from platform_daemon.schemas import DiagnosisReport, DiagnosisRequest, NoResult, to_json
from platform_daemon.store import write_file
from platform_daemon.workers import Computer

from ..computed import computed
from ..jobs import AnyJob

if TYPE_CHECKING:
    from platform_daemon.analysis import ModelChoice
    from platform_daemon.diagnosis import ResidualComparison


@dataclass(frozen=True)
class DiagnosisTask:
    """Says what the declared model lacks in these frames of files.  A task for whoever computes.

    page: makes the page.
    """

    request: DiagnosisRequest
    files: Mapping[Path, Sequence[int] | None]
    model: ModelChoice | None
    page: Callable[[DiagnosisReport, ResidualComparison], bytes]

    def __call__(self, tell: Callable[[float, str], None]) -> tuple[DiagnosisReport, bytes]:
        """Report and page.  Raises NothingToDiagnoseError."""
        tell(0.0, "reading")
        files = list(self.files)
        specimen = analysis.load_diagnosis_input(files, self.model, self.request.observable, frames=self.files)
        found = analysis.diagnose_input(specimen, lambda what, share: tell(share, what))
        known = {"files": tuple(f.name for f in files), "recordings": analysis.file_digests(files)}
        report = diagnosis.diagnosis_report(found).model_copy(update=known)
        tell(0.95, "page")
        return report, self.page(report, diagnosis.compare_residuals(found))


@dataclass(frozen=True)
class DiagnosisWork:
    """Says what the declared model lacks; report and page are kept in `folder`."""

    request: DiagnosisRequest
    task: DiagnosisTask
    folder: Path
    computer: Computer
    kind, unit, total, no_result = "diagnosis", "share", 1.0, NoResult()

    def __call__(self, job: AnyJob) -> None:
        """Raises Cancelled, OverBounds, WorkerLost, NothingToDiagnoseError, StorageError."""
        report, page = computed(self.computer, self.kind, self.task, job)
        job.at(1.0, "write")
        write_file(self.folder / f"{job.identifier}.html", page)
        write_file(self.folder / f"{job.identifier}.json", to_json(report, indent=1).encode())
        job.result = report
