"""Characterisations of stored recordings as jobs; report and page are kept on disk."""

from __future__ import annotations

from fastapi import APIRouter, Response
from fastapi.responses import FileResponse, HTMLResponse

from platform_daemon import reports  # not its parts: they load matplotlib when they are first used
from platform_daemon.analysis import FitSettings, characterisation_task, resolve
from platform_daemon.engine import CharacterisationFiles, CharacterisationWork
from platform_daemon.link import ShownJob
from platform_daemon.schemas import CharacterisationJob, CharacterisationJobs, CharacterisationRequest
from platform_daemon.store import resolve as path_of

from ..context import JobId, Shared
from ..job_routes import JobKind, page_of
from ..network.routes import GuardedRoute
from ..problems import problems

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
    frames = None if body.frames is None else tuple(body.frames)
    settings = FitSettings(resolve(body.variant, context.models), terms=tuple(body.terms), frames=frames)
    path = path_of(context.recordings, body.recording)
    task = characterisation_task(path, settings, body.held_in_n50 or None, body.alpha)
    files = CharacterisationFiles(reports.characterisation_html, context.characterisations)
    work = CharacterisationWork(body, task, files, context.analyses.computer)
    return CHARACTERISATIONS.accepted(ShownJob.of(context.analyses.analyse(work)), response)


CHARACTERISATIONS.add_routes(router)


@router.get(
    "/{identifier}/report",
    summary="The page with tables and pictures",
    response_class=HTMLResponse,
    responses=problems(404, 422),
)
def get_characterisation_report(identifier: JobId, context: Shared) -> FileResponse:
    """One self-contained HTML page: a shot with its fit, envelopes, the tables, every parameter shot by shot."""
    job = context.holder("characterisation").job("characterisation", identifier)
    return page_of(job, context.characterisations, "characterise anew")
