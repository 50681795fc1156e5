"""A characterisation of a stored recording as a job; report and page are kept on disk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon import analysis
from platform_daemon.schemas import CharacterisationReport, CharacterisationRequest, NoResult, to_json
from platform_daemon.store import write_file
from platform_daemon.workers import Computer

from ..computed import computed
from ..jobs import AnyJob

if TYPE_CHECKING:
    from platform_daemon.analysis import CharacterisationTask, RingDownPlotData

    Page = Callable[[CharacterisationReport, RingDownPlotData | None], bytes]
    """Makes the page from the report and the shot of its figures."""


@dataclass(frozen=True)
class CharacterisationFiles:
    """Where report and page are kept: in `folder` as ID.json and ID.html of the job's id, or where `report` and `html`
    say; a file that neither says is not written.

    page: makes the page.
    """

    page: Page
    folder: Path | None = None
    report: Path | None = None
    html: Path | None = None

    def named(self, job: str) -> tuple[Path | None, Path | None]:
        """(report, page) of the job of that id."""
        if self.folder is None:
            return self.report, self.html
        return self.folder / f"{job}.json", self.folder / f"{job}.html"


@dataclass(frozen=True)
class Tables:
    """Fits in both windows, and the paper's tables.  A task for whoever computes.

    task: makes what is to be characterised; page: makes the page, None: none is wanted.
    """

    task: Callable[[], CharacterisationTask]
    page: Page | None

    def __call__(self, tell: Callable[[float, str], None]) -> tuple[CharacterisationReport, bytes | None]:
        """Report and page.  Raises what `task` raises, PlatformError if no frame can be read."""
        task = self.task()
        with analysis.in_this_process() as workers:
            found = analysis.characterise(task, workers, lambda what, share: tell(share, what))
        report = found.model_copy(update={"file": task.path.name})
        if self.page is None:
            return report, None
        tell(0.99, "page")
        return report, self.page(report, analysis.shown_shot(task, report))


@dataclass(frozen=True)
class Known:
    """What is to be characterised, checked already."""

    task: CharacterisationTask

    def __call__(self) -> CharacterisationTask:
        """It."""
        return self.task


def keep_tables(
    report: CharacterisationReport, page: bytes | None, files: CharacterisationFiles | None, job: AnyJob
) -> None:
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
    files: CharacterisationFiles
    computer: Computer
    kind, unit, total, no_result = "characterisation", "share", 1.0, NoResult()

    def __call__(self, job: AnyJob) -> None:
        """Raises Cancelled, OverBounds, WorkerLost, StorageError."""
        report, page = computed(self.computer, self.kind, Tables(Known(self.task), self.files.page), job)
        keep_tables(report, page, self.files, job)
        job.at(1.0, "write")
        job.result = report
