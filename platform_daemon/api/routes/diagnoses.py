"""Diagnoses of stored recordings as jobs; results are kept on disk, and what they name can be adopted."""

from __future__ import annotations

from fastapi import APIRouter, Response
from fastapi.responses import HTMLResponse

from platform_daemon import analysis
from platform_daemon.link import ShownJob
from platform_daemon.schemas import (
    AdoptedModelRecord,
    AdoptionRequest,
    DiagnosisJob,
    DiagnosisJobs,
    DiagnosisReport,
    DiagnosisRequest,
)

from ..context import JobId, Shared
from ..job_routes import PAGE, JobKind, page_of, result_of
from ..network.routes import GuardedRoute
from ..problems import problems
from ..ranged_file import RangedFile
from ..stored_work import diagnosis_work

router = APIRouter(prefix="/diagnoses", tags=["diagnoses"], route_class=GuardedRoute)
AGAIN = "diagnose anew"


def _links(job: ShownJob) -> dict[str, str]:
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
    return DIAGNOSES.accepted(ShownJob.of(context.analyses.analyse(diagnosis_work(body, context))), response)


DIAGNOSES.add_routes(router)


@router.get(
    "/{identifier}/report",
    summary="The page with pictures",
    response_class=HTMLResponse,
    responses=PAGE,
)
def get_report(identifier: JobId, context: Shared) -> RangedFile:
    """One self-contained HTML page: residual, harmonics, spectra, sliding windows, ranking, before and after."""
    return page_of(context.holder("diagnosis").job("diagnosis", identifier), context.diagnoses, AGAIN)


@router.post(
    "/{identifier}/adopt",
    summary="Adopt what it names",
    status_code=201,
    responses=problems(404, 415, 422, 507),
)
def adopt_model(identifier: JobId, body: AdoptionRequest, response: Response, context: Shared) -> AdoptedModelRecord:
    """Make the declared model with the named effects a named, versioned model for later fits."""
    found: DiagnosisReport = result_of(context.holder("diagnosis").job("diagnosis", identifier), AGAIN)
    model = analysis.model_from_diagnosis(
        found, body.name, body.by, context.models, effects=body.effects, free=body.free, force=body.force
    )
    made = context.models.add(model)
    response.headers["Location"] = f"/models/{made.label}"
    return made.record()
