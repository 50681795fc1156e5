"""Diagnoses of stored recordings as jobs; results are kept on disk, and what they name can be adopted."""

from __future__ import annotations

from fastapi import Response
from fastapi.responses import HTMLResponse

from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.web.context import JobId, Shared
from platform_daemon.core.web.job_routes import PAGE, JobRoutes, page_of, result_of
from platform_daemon.core.web.problems import problems
from platform_daemon.core.web.ranged_file import RangedFile
from platform_daemon.diagnosis.report_schema import DiagnosisReport
from platform_daemon.features.models.library import Library
from platform_daemon.features.models.schema import AdoptedModelRecord

from .request_schema import AdoptionRequest

AGAIN = "diagnose again"


def _links(job: JobView) -> dict[str, str]:
    here = f"/diagnoses/{job.identifier}"
    return {"report": f"{here}/report", "adopt": f"{here}/adopt"}


DIAGNOSES = JobRoutes("diagnosis", _links)
router = DIAGNOSES.router()


DIAGNOSES.add_job_routes(router)


@router.get(
    "/{identifier}/report",
    summary="The page with pictures",
    response_class=HTMLResponse,
    responses=PAGE,
)
def get_report(identifier: JobId, context: Shared) -> RangedFile:
    """One self-contained HTML page: residual, harmonics, spectra, sliding windows, ranking, before and after."""
    return page_of(context.jobs_of("diagnosis").job("diagnosis", identifier), context.folders.diagnoses, AGAIN)


@router.post(
    "/{identifier}/adopt",
    summary="Adopt what it names",
    status_code=201,
    responses=problems(404, 415, 422, 423, 507),
)
def adopt_model(identifier: JobId, body: AdoptionRequest, response: Response, context: Shared) -> AdoptedModelRecord:
    """Make the declared model with the named effects a named, versioned model for later fits."""
    from .adoption import model_from_diagnosis

    found: DiagnosisReport = result_of(context.jobs_of("diagnosis").job("diagnosis", identifier), AGAIN)
    model = model_from_diagnosis(
        found,
        body.name,
        body.by,
        Library(context.folders.models),
        effects=body.effects,
        free=body.free,
        force=body.force,
    )
    made = Library(context.folders.models).add(model)
    response.headers["Location"] = f"/models/{made.label}"
    return made.record()
