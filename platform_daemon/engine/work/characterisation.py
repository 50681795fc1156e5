"""A characterisation of a stored recording as a job; report and page are kept on disk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from platform_daemon import analysis
from platform_daemon.schemas import CharacterisationReport, CharacterisationRequest, NoResult, to_json
from platform_daemon.store import write_file

from ..jobs import AnyJob, Cancelled

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


def characterise_to_disk(
    task: CharacterisationTask, files: CharacterisationFiles | None, job: AnyJob, tell: Callable[[str, float], None]
) -> CharacterisationReport:
    """Fit in this process, frame after frame, and keep report and page.  Raises what `tell` raises, StorageError."""
    with analysis.in_this_process() as workers:
        found = analysis.characterise(task, workers, tell)
    report = found.model_copy(update={"file": task.path.name})
    target, html = (None, None) if files is None else files.named(job.identifier)
    if files is not None and html is not None:
        tell("page", 0.99)
        write_file(html, files.page(report, analysis.shown_shot(task, report)))
    if target is not None:
        write_file(target, to_json(report, indent=1).encode())
    tell("write", 1.0)
    if not (report.n50.good or report.d30.good):
        job.warnings.append("every shot was refused in both windows")
    return report


@dataclass(frozen=True)
class CharacterisationWork:
    """Fits the shots of a recording in both windows; report and page are kept."""

    request: CharacterisationRequest
    task: CharacterisationTask
    files: CharacterisationFiles
    kind, unit, total, no_result = "characterisation", "share", 1.0, NoResult()

    def __call__(self, job: AnyJob) -> None:
        """Raises Cancelled between fits, StorageError."""

        def tell(what: str, share: float) -> None:
            job.at(share, what)
            if job.cancel_requested.is_set():
                raise Cancelled

        job.result = characterise_to_disk(self.task, self.files, job, tell)
