"""A diagnosis of stored recordings as a job; report and page are kept on disk."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon.core.jobs.jobs import AnyJob
from platform_daemon.core.jobs.run_task import run_task
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.core.recordings.index import resolve as path_of
from platform_daemon.core.schemas.base import NoResult, to_json
from platform_daemon.core.service.bench import AnalysisBench
from platform_daemon.core.state.durable import write_file
from platform_daemon.diagnosis.report_schema import DiagnosisReport
from platform_daemon.features.models.library import Library

from .request_schema import DiagnosisRequest

if TYPE_CHECKING:
    from platform_daemon.features.models.resolve import ModelChoice


@dataclass(frozen=True)
class DiagnosisTask:
    """Says what the declared model lacks in these frames of files.  A task of the task executor."""

    request: DiagnosisRequest
    files: Mapping[Path, Sequence[int] | None]
    model: ModelChoice | None
    steps: Mapping[Path, str | None] = field(default_factory=dict)

    def __call__(self, tell: Callable[[float, str], None]) -> tuple[DiagnosisReport, bytes]:
        """Report and page.  Raises NothingToDiagnoseError."""
        from platform_daemon.core.recordings.evidence import file_digests
        from platform_daemon.diagnosis.report import diagnosis_report
        from platform_daemon.diagnosis.residual_comparison import compare_residuals

        from .load_shots import diagnose_input, load_diagnosis_input
        from .page import diagnosis_html

        tell(0.0, "reading")
        files = list(self.files)
        specimen = load_diagnosis_input(files, self.model, self.request.observable, frames=self.files, steps=self.steps)
        found = diagnose_input(specimen, lambda what, share: tell(share, what))
        report = diagnosis_report(
            found,
            files=[f.name for f in files],
            recordings=file_digests(files),
            value_sources=specimen.recorded_sources(lambda path: path.name),
        )
        tell(0.95, "page")
        return report, diagnosis_html(report, compare_residuals(found))


@dataclass(frozen=True)
class DiagnosisWork:
    """Says what the declared model lacks; report and page are kept in `folder`."""

    request: DiagnosisRequest
    task: DiagnosisTask
    folder: Path
    executor: TaskExecutor
    kind, unit, total, no_result = "diagnosis", "share", 1.0, NoResult()
    duration_s = None

    def __call__(self, job: AnyJob) -> None:
        """Raises Cancelled, OverBounds, WorkerLost, NothingToDiagnoseError, StorageError."""
        report, page = run_task(self.executor, self.kind, self.task, job)
        job.at(1.0, "write")
        write_file(self.folder / f"{job.identifier}.html", page)
        write_file(self.folder / f"{job.identifier}.json", to_json(report, indent=1).encode())
        job.result = report


def plan(bench: AnalysisBench, request: DiagnosisRequest) -> DiagnosisWork:
    """The work of a diagnosis.  Raises InputError for a file or model that cannot be."""
    from platform_daemon.features.models.resolve import resolve

    from .load_shots import check_diagnosis_input

    parts = {path_of(bench.folders.recordings, part.recording): part for part in request.parts()}
    files = {path: part.frames for path, part in parts.items()}
    steps = {path: part.step for path, part in parts.items()}
    model = resolve(request.base or request.variant, Library(bench.folders.models))
    check_diagnosis_input(list(files), model, request.observable, frames=files, steps=steps)
    return DiagnosisWork(request, DiagnosisTask(request, files, model, steps), bench.folders.diagnoses, bench.executor)
