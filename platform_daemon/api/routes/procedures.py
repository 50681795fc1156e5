"""Procedures as jobs: ask (202), watch step by step, pause, resume, cancel."""

from __future__ import annotations

from fastapi import APIRouter, Response
from fastapi.responses import HTMLResponse

from drivers.errors import InputError
from platform_daemon.link import ShownJob
from platform_daemon.schemas import (
    AnyProcedureRequest,
    CharacteriseOutcome,
    ProcedureJob,
    ProcedureJobs,
    ProcedureSummary,
)

from ..context import CONFIRMED, Confirmed, JobId, Shared
from ..job_routes import PAGE, JobKind, page_of
from ..network.routes import GuardedRoute
from ..problems import OWNER, problems
from ..ranged_file import RangedFile

router = APIRouter(prefix="/procedures", tags=["procedures"], route_class=GuardedRoute, responses=problems(*OWNER))


def _links(job: ShownJob) -> dict[str, str]:
    found = {} if job.result.recording is None else {"recording": f"/recordings/{job.result.recording}"}
    if isinstance(job.result.outcome, CharacteriseOutcome):
        found["report"] = f"/procedures/{job.identifier}/report"
    if not job.state.final:
        what = "resume" if job.paused else "pause"
        found[what] = f"/procedures/{job.identifier}/{what}"
    return found


PROCEDURES = JobKind(
    "procedure",
    "procedures",
    ProcedureJob,
    ProcedureJobs,
    _links,
    got="State, progress with time left, and every step so far: values, medians of the fits, verdict.",
    cancelled="Cancel.  A running shot ends within 0.1 s with outputs off and is discarded; shots on disk stay.",
)


@router.post("", summary="Measure step by step", status_code=202, responses=problems(409, 415, 422, 507))
def start_procedure(body: AnyProcedureRequest, response: Response, context: Shared) -> ProcedureJob:
    """Queue a procedure: a sweep over keys of an acquisition, or a characterisation of a resonator.

    Every step is checked first: one outside the safety envelope is answered 422 with its number, and nothing moves.
    Procedures run one after the other.  Each step is an acquisition that waits its turn among all others; the shots of
    all steps are in one recording, which has the id of the procedure.
    """
    return PROCEDURES.accepted(context.hardware.conduct(body), response)


@router.post("/dry-run", summary="Check a procedure without moving anything", responses=problems(409, 415, 422, 507))
def dry_run_procedure(body: AnyProcedureRequest, context: Shared) -> ProcedureSummary:
    """The same checks, nothing moves: every step with its values, shots, duration and disk.

    507 if the disk cannot take it.
    """
    return context.hardware.dry_run_procedure(body)


@router.put("/{identifier}", summary="Change what has not begun", responses=problems(404, 409, 415, 422, 507))
def edit_procedure(identifier: JobId, body: AnyProcedureRequest, context: Shared) -> ProcedureJob:
    """Another request in the place of that of a procedure that waits; 409 once it has begun."""
    return PROCEDURES.shown(context.hardware.edit("procedure", identifier, body))


PROCEDURES.add_routes(router)


@router.post(
    "/{identifier}/pause",
    summary="Rest at the next safe point",
    status_code=202,
    responses=problems(404, 409, 415, 422),
)
def pause_procedure(identifier: JobId, context: Shared, body: Confirmed = CONFIRMED) -> ProcedureJob:
    """Rest after the shot under way, with outputs off, until it is resumed; other jobs run meanwhile.

    A pause longer than `longest_pause_s` of the request ends the procedure.
    """
    return PROCEDURES.shown(context.hardware.pause("procedure", identifier))


@router.post(
    "/{identifier}/resume", summary="Go on after a pause", status_code=202, responses=problems(404, 409, 415, 422)
)
def resume_procedure(identifier: JobId, context: Shared, body: Confirmed = CONFIRMED) -> ProcedureJob:
    """Go on with the shots that are missing; nothing happens if it is not paused."""
    return PROCEDURES.shown(context.hardware.resume("procedure", identifier))


@router.get(
    "/{identifier}/report",
    summary="The page of a characterisation",
    response_class=HTMLResponse,
    responses=PAGE,
)
def get_procedure_report(identifier: JobId, context: Shared) -> RangedFile:
    """What `GET /characterisations/{identifier}/report` is to a stored recording."""
    job = context.hardware.job("procedure", identifier)
    if not isinstance(job.result.outcome, CharacteriseOutcome):
        why = f"it is {job.state}" + (f": {job.error}" if job.error is not None else "")
        remedy = "wait for a characterisation to end; of any recording POST /characterisations makes one"
        raise InputError("the procedure has no report", where=identifier, why=why, remedy=remedy)
    return page_of(job, context.characterisations, "characterise its recording anew")
