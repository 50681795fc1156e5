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
class CharacterisationWork:
    """Fits the shots of a recording in both windows; report and page are kept in `folder`."""

    request: CharacterisationRequest
    task: CharacterisationTask
    folder: Path
    page: Page
    kind, unit, total, no_result = "characterisation", "share", 1.0, NoResult()

    def __call__(self, job: AnyJob) -> None:
        """Raises Cancelled between fits, StorageError."""

        def tell(what: str, share: float) -> None:
            job.at(share, what)
            if job.cancel_requested.is_set():
                raise Cancelled

        with analysis.in_this_process() as workers:
            found = analysis.characterise(self.task, workers, tell)
        report = found.model_copy(update={"file": self.task.path.name})
        tell("page", 0.99)
        page = self.page(report, analysis.shown_shot(self.task, report))
        job.at(1.0, "write")
        write_file(self.folder / f"{job.identifier}.html", page)
        write_file(self.folder / f"{job.identifier}.json", to_json(report, indent=1).encode())
        job.result = report
        if not (report.n50.good or report.d30.good):
            job.warnings.append("every shot was refused in both windows")
