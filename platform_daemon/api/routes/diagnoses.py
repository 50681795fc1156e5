"""Diagnoses of stored recordings as jobs; results are kept on disk, and what they name can be adopted."""

from __future__ import annotations

from pathlib import Path

from fastapi import APIRouter, Response
from fastapi.responses import FileResponse, HTMLResponse

from drivers.errors import InputError
from platform_daemon.analysis import ModelChoice, check_diagnosis_input, model_from_diagnosis, resolve
from platform_daemon.engine import AnyJob, DiagnosisWork, UnknownId
from platform_daemon.reports import diagnosis_html
from platform_daemon.schemas import (
    AdoptedModelRecord,
    AdoptionRequest,
    DiagnosisJob,
    DiagnosisJobs,
    DiagnosisReport,
    DiagnosisRequest,
)
from platform_daemon.store import resolve as path_of

from ..context import Context, JobId, Shared
from ..job_routes import JobKind
from ..problems import problems

router = APIRouter(prefix="/diagnoses", tags=["diagnoses"])


def _links(job: AnyJob) -> dict[str, str]:
    here = f"/diagnoses/{job.identifier}"
    return {"report": f"{here}/report", "adopt": f"{here}/adopt"}


DIAGNOSES = JobKind(
    "diagnosis",
    "diagnoses",
    DiagnosisJob,
    DiagnosisJobs,
    _links,
    got="State, progress, and the result once it is there.",
    cancelled="Cancel after the step under way.",
)


@router.post("", summary="Diagnose recordings", status_code=202, responses=problems(404, 415, 422, 503, 507))
def start_diagnosis(body: DiagnosisRequest, response: Response, context: Shared) -> DiagnosisJob:
    """Say what the declared model lacks.  `result` is the same object that `platform-daemon diagnose --json` writes."""
    files = {path_of(context.recordings, part.recording): part.frames for part in body.parts()}
    model: ModelChoice | None = resolve(body.base or body.variant, context.models)
    check_diagnosis_input(list(files), model, body.observable, frames=files)
    job = context.engine.analyse(DiagnosisWork(body, files, model, context.diagnoses, diagnosis_html))
    return DIAGNOSES.accepted(job, response)


def _page(identifier: str, context: Context) -> Path:
    return context.diagnoses / f"{identifier}.html"


DIAGNOSES.add_routes(router)


@router.get(
    "/{identifier}/report",
    summary="The page with pictures",
    response_class=HTMLResponse,
    responses=problems(404, 422),
)
def get_report(identifier: JobId, context: Shared) -> FileResponse:
    """One self-contained HTML page: residual, harmonics, spectra, sliding windows, ranking, before and after."""
    _result(identifier, context)
    page = _page(identifier, context)
    if not page.is_file():
        raise UnknownId("the page is not there any more", where=identifier, remedy="diagnose again")
    return FileResponse(page, media_type="text/html")


@router.post(
    "/{identifier}/adopt",
    summary="Adopt what it names",
    status_code=201,
    responses=problems(404, 415, 422, 507),
)
def adopt_model(identifier: JobId, body: AdoptionRequest, response: Response, context: Shared) -> AdoptedModelRecord:
    """Make the declared model with the named effects a named, versioned model for later fits."""
    found = _result(identifier, context)
    model = model_from_diagnosis(
        found, body.name, body.by, context.models, effects=body.effects, free=body.free, force=body.force
    )
    made = context.models.add(model)
    response.headers["Location"] = f"/models/{made.label}"
    return made.record()


def _result(identifier: str, context: Context) -> DiagnosisReport:
    """The result of a diagnosis.  Raises UnknownId, InputError if there is none."""
    job = context.engine.job("diagnosis", identifier)
    if isinstance(job.result, DiagnosisReport):
        return job.result
    why = f"it is {job.state}" + (f": {job.error}" if job.error is not None else "")
    remedy = "remove the cause and diagnose anew" if job.state.final else "wait until its state is done"
    raise InputError("the diagnosis has no result", where=identifier, why=why, remedy=remedy)
