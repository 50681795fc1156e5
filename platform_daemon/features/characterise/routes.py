"""Characterisations of stored recordings as jobs; report and page are kept on disk."""

from __future__ import annotations

from fastapi.responses import HTMLResponse

from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.web.context import JobId, Shared
from platform_daemon.core.web.job_routes import PAGE, JobRoutes, page_of
from platform_daemon.core.web.ranged_file import RangedFile


def _links(job: JobView) -> dict[str, str]:
    return {"report": f"/characterisations/{job.identifier}/report"}


CHARACTERISATIONS = JobRoutes("characterisation", _links)
router = CHARACTERISATIONS.router()


CHARACTERISATIONS.add_job_routes(router)


@router.get(
    "/{identifier}/report",
    summary="The page with tables and pictures",
    response_class=HTMLResponse,
    responses=PAGE,
)
def get_characterisation_report(identifier: JobId, context: Shared) -> RangedFile:
    """One self-contained HTML page: a shot with its fit, envelopes, the tables, every parameter shot by shot."""
    job = context.jobs_of("characterisation").job("characterisation", identifier)
    return page_of(job, context.folders.characterisations, "characterise again")
