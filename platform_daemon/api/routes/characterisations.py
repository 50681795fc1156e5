"""Characterisations of stored recordings as jobs; report and page are kept on disk."""

from __future__ import annotations

from fastapi import APIRouter, Response
from fastapi.responses import HTMLResponse

from platform_daemon.link import ShownJob
from platform_daemon.schemas import CharacterisationJob, CharacterisationJobs, CharacterisationRequest

from ..context import JobId, Shared
from ..job_routes import PAGE, JobKind, page_of
from ..network.routes import GuardedRoute
from ..problems import problems
from ..ranged_file import RangedFile
from ..stored_work import characterisation_work

router = APIRouter(prefix="/characterisations", tags=["characterisations"], route_class=GuardedRoute)


def _links(job: ShownJob) -> dict[str, str]:
    return {"report": f"/characterisations/{job.identifier}/report"}


CHARACTERISATIONS = JobKind(
    "characterisation",
    "characterisations",
    CharacterisationJob,
    CharacterisationJobs,
    _links,
    got="State, progress with time left, and the result once it is there.",
    cancelled="Cancel after the fit under way.",
)


@router.post("", summary="Characterise a resonator", status_code=202, responses=problems(404, 415, 422, 503, 507))
def start_characterisation(body: CharacterisationRequest, response: Response, context: Shared) -> CharacterisationJob:
    """Fit every shot of a recording over N50 and D30: the paper's tables, and whether the two windows agree.

    `result` is the same object that `platform-daemon characterise --json` writes.
    """
    work = characterisation_work(body, context)
    return CHARACTERISATIONS.accepted(ShownJob.of(context.analyses.analyse(work)), response)


CHARACTERISATIONS.add_routes(router)


@router.get(
    "/{identifier}/report",
    summary="The page with tables and pictures",
    response_class=HTMLResponse,
    responses=PAGE,
)
def get_characterisation_report(identifier: JobId, context: Shared) -> RangedFile:
    """One self-contained HTML page: a shot with its fit, envelopes, the tables, every parameter shot by shot."""
    job = context.holder("characterisation").job("characterisation", identifier)
    return page_of(job, context.characterisations, "characterise anew")
