"""Procedures as jobs: ask (202), watch step by step, pause, resume, cancel."""

from __future__ import annotations

from fastapi.responses import HTMLResponse

from drivers.errors import InputError
from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.web.context import JobId, Shared
from platform_daemon.core.web.job_routes import PAGE, JobRoutes, page_of
from platform_daemon.core.web.problems import problems
from platform_daemon.core.web.ranged_file import RangedFile

from .schema import AnyProcedureRequest, ProcedureSummary


def makes_page(job: JobView) -> bool:
    """True if the outcome of the procedure has a page."""
    return job.result.outcome is not None and job.result.outcome.makes_page


def _links(job: JobView) -> dict[str, str]:
    found = {} if job.result.recording is None else {"recording": f"/recordings/{job.result.recording}"}
    if makes_page(job):
        found["report"] = f"/procedures/{job.identifier}/report"
    if not job.state.final:
        what = "resume" if job.paused else "pause"
        found[what] = f"/procedures/{job.identifier}/{what}"
    return found


PROCEDURES = JobRoutes("procedure", _links)
router = PROCEDURES.router()


@router.post("/dry-run", summary="Check a procedure without moving anything", responses=problems(409, 415, 422, 507))
def dry_run_procedure(body: AnyProcedureRequest, context: Shared) -> ProcedureSummary:
    """The same checks, nothing moves: every step with its values, shots, duration and disk.

    507 if the disk cannot take it.
    """
    found = context.hardware.dry_run("procedure", body)
    assert isinstance(found, ProcedureSummary)
    return found


PROCEDURES.add_job_routes(router)
PROCEDURES.add_pause_routes(
    router,
    ends="A pause longer than `longest_pause_s` of the request ends the procedure.",
    resume=("Go on after a pause", "Go on with the shots that are missing; nothing happens if it is not paused."),
)


@router.get(
    "/{identifier}/report",
    summary="The page of a characterisation",
    response_class=HTMLResponse,
    responses=PAGE,
)
def get_procedure_report(identifier: JobId, context: Shared) -> RangedFile:
    """What `GET /characterisations/{identifier}/report` is to a stored recording."""
    job = context.hardware.job("procedure", identifier)
    if not makes_page(job):
        why = f"it is {job.state}" + (f": {job.error}" if job.error is not None else "")
        remedy = "wait for a characterisation to end; of any recording POST /characterisations makes one"
        raise InputError("the procedure has no report", where=identifier, why=why, remedy=remedy)
    return page_of(job, context.folders.characterisations, "characterise its recording again")
