"""A characterisation of a stored recording as a job; report and page are kept on disk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from platform_daemon.core.jobs.jobs import AnyJob
from platform_daemon.core.jobs.run_task import run_task
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.core.recordings.index import resolve as path_of
from platform_daemon.core.schemas.base import NoResult, to_json
from platform_daemon.core.service.bench import AnalysisBench
from platform_daemon.core.state.durable import write_file
from platform_daemon.features.models.library import Library
from platform_daemon.features.procedures.bench import ReportFiles

from .schema import CharacterisationReport, CharacterisationRequest

if TYPE_CHECKING:
    from .tables import CharacterisationTask


@dataclass(frozen=True)
class Tables:
    """Fits in both windows, and the paper's tables.  A task of the task executor.

    task: makes what is to be characterised; with_page: the page is made, too.
    """

    task: Callable[[], CharacterisationTask]
    with_page: bool

    def __call__(self, tell: Callable[[float, str], None]) -> tuple[CharacterisationReport, bytes | None]:
        """Report and page.  Raises what `task` raises, PlatformError if no frame can be read."""
        from platform_daemon.features.fit.batch.executors import in_this_process

        from .page import characterisation_html
        from .tables import characterise, shown_shot

        task = self.task()
        with in_this_process() as workers:
            found = characterise(task, workers, lambda what, share: tell(share, what))
        report = found.model_copy(update={"file": task.path.name})
        if not self.with_page:
            return report, None
        tell(0.99, "page")
        return report, characterisation_html(report, shown_shot(task, report))


@dataclass(frozen=True)
class Known:
    """What is to be characterised, checked already."""

    task: CharacterisationTask

    def __call__(self) -> CharacterisationTask:
        """It."""
        return self.task


def keep_tables(report: CharacterisationReport, page: bytes | None, files: ReportFiles | None, job: AnyJob) -> None:
    """Report and page onto the disk.  Raises StorageError."""
    target, html = (None, None) if files is None else files.named(job.identifier)
    if html is not None and page is not None:
        write_file(html, page)
    if target is not None:
        write_file(target, to_json(report, indent=1).encode())
    if not (report.n50.good or report.d30.good):
        job.warnings.append("every shot was refused in both windows")


@dataclass(frozen=True)
class CharacterisationWork:
    """Fits the shots of a recording in both windows; report and page are kept."""

    request: CharacterisationRequest
    task: CharacterisationTask
    files: ReportFiles
    executor: TaskExecutor
    kind, unit, total, no_result = "characterisation", "share", 1.0, NoResult()
    duration_s = None

    def __call__(self, job: AnyJob) -> None:
        """Raises Cancelled, OverBounds, WorkerLost, StorageError."""
        report, page = run_task(self.executor, self.kind, Tables(Known(self.task), with_page=True), job)
        keep_tables(report, page, self.files, job)
        job.at(1.0, "write")
        job.result = report


def plan(bench: AnalysisBench, request: CharacterisationRequest) -> CharacterisationWork:
    """The work of characterising a recording.  Raises InputError for a file, model or frame that cannot be."""
    from platform_daemon.features.fit.fit_request import FitSettings
    from platform_daemon.features.models.resolve import resolve

    from .tables import characterisation_task

    model = resolve(request.variant, Library(bench.folders.models))
    frames = None if request.frames is None else tuple(request.frames)
    settings = FitSettings(model, terms=tuple(request.terms), frames=frames, step=request.step)
    path = path_of(bench.folders.recordings, request.recording)
    task = characterisation_task(path, settings, request.held_in_n50 or None, request.alpha)
    return CharacterisationWork(request, task, ReportFiles(folder=bench.folders.characterisations), bench.executor)
