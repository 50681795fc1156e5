"""Campaigns as jobs: ask (202), watch, pause, resume, cancel; the report."""

from __future__ import annotations

from fastapi.responses import HTMLResponse

from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.web.context import JobId, Shared
from platform_daemon.core.web.job_routes import PAGE, JobRoutes, result_of
from platform_daemon.core.web.ranged_file import RangedFile


def _links(job: JobView) -> dict[str, str]:
    here = f"/reproductions/{job.identifier}"
    if not isinstance(job.result, NoResult):
        return {"report": f"{here}/report"}
    if job.state.final or job.paused:
        return {"resume": f"{here}/resume"}
    return {"pause": f"{here}/pause"}


REPRODUCTIONS = JobRoutes("reproduction", _links)
router = REPRODUCTIONS.router()
REPRODUCTIONS.add_job_routes(router)
REPRODUCTIONS.add_pause_routes(
    router,
    ends="A pause of more than 8 hours ends it.",
    resume=(
        "Go on after a pause, or after it was cut off",
        "Go on.  Of one that has ended early, a resonator that was measured whole stays, and the others are measured.",
    ),
    cut_off=True,
)


@router.get("/{identifier}/report", summary="The page of a campaign", response_class=HTMLResponse, responses=PAGE)
def get_reproduction_report(identifier: JobId, context: Shared) -> RangedFile:
    """One self-contained HTML page: every claim, the paper's tables with both resonators in each, its figures."""
    result_of(context.hardware.job("reproduction", identifier), "resume it")
    page = context.folders.reproductions / identifier / "report.html"
    if not page.is_file():
        raise UnknownId("the page is not there any more", where=identifier, remedy="ask for a new campaign")
    return RangedFile(page, "text/html")
