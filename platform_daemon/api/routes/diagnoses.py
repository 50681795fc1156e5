"""Diagnoses of stored recordings as jobs; results are kept on disk, and what they name can be adopted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Response
from fastapi.responses import FileResponse

from drivers.errors import InputError
from platform_daemon.analysis import (
    ModelChoice,
    check_diagnosis_input,
    file_digests,
    load_diagnosis_input,
    model_from_diagnosis,
    resolve,
)
from platform_daemon.engine import Cancelled, Job, UnknownId
from platform_daemon.reports import diagnosed
from platform_daemon.store import resolve as path_of
from platform_daemon.store import write_file

from ..context import Context, Shared, job_body
from ..models import AdoptBody, DiagnosisBody, JobModel, ProblemModel

router = APIRouter(prefix="/diagnoses", tags=["diagnoses"])
ERRORS: dict[int | str, dict[str, Any]] = {404: {"model": ProblemModel}, 422: {"model": ProblemModel}}


def _body(job: Job) -> dict[str, Any]:
    here = f"/diagnoses/{job.identifier}"
    return job_body(job, {"self": here, "report": f"{here}/report", "adopt": f"{here}/adopt"})


@router.post("", summary="Diagnose recordings", status_code=202, response_model=JobModel, responses=ERRORS)
def start_diagnosis(body: DiagnosisBody, response: Response, context: Shared) -> dict[str, Any]:
    """Say what the declared model lacks.  `result` is the same object that `platform-daemon diagnose --json` writes."""
    files = {path_of(context.recordings, part.recording): part.frames for part in body.parts()}
    model: ModelChoice | None = resolve(body.base or body.variant, context.models)
    check_diagnosis_input(list(files), model, body.observable, frames=files)

    def work(job: Job) -> None:
        def tell(what: str, share: float) -> None:
            job.at(share, what)
            if job.cancel_requested.is_set():
                raise Cancelled

        tell("reading", 0.0)
        report, page = diagnosed(load_diagnosis_input(list(files), model, body.observable, frames=files), tell)
        job.result = report | {"files": [f.name for f in files], "recordings": file_digests(files)}
        job.at(1.0, "write")
        write_file(_page(job.identifier, context), page)
        write_file(context.diagnoses / f"{job.identifier}.json", json.dumps(job.result, indent=1).encode())

    job = context.engine.analyse(body.model_dump(mode="json"), 1.0, work, "diagnosis", "share")
    response.headers["Location"] = f"/diagnoses/{job.identifier}"
    return _body(job)


def _page(identifier: str, context: Context) -> Path:
    return context.diagnoses / f"{identifier}.html"


@router.get("", summary="All diagnoses", response_model=list[JobModel])
def list_diagnoses(context: Shared) -> list[dict[str, Any]]:
    """All diagnoses asked for, oldest first."""
    return [_body(job) for job in context.engine.jobs("diagnosis")]


@router.get("/{identifier}", summary="How far it is, and the result", response_model=JobModel, responses=ERRORS)
def get_diagnosis(identifier: str, context: Shared) -> dict[str, Any]:
    """State, progress, and the result once it is there."""
    return _body(context.engine.job("diagnosis", identifier))


@router.delete("/{identifier}", summary="Cancel", status_code=202, response_model=JobModel, responses=ERRORS)
def cancel_diagnosis(identifier: str, context: Shared) -> dict[str, Any]:
    """Cancel after the step under way."""
    job = context.engine.job("diagnosis", identifier)
    job.request_cancel()
    return _body(job)


@router.get("/{identifier}/report", summary="The page with pictures", response_class=FileResponse, responses=ERRORS)
def get_report(identifier: str, context: Shared) -> FileResponse:
    """One self-contained HTML page: residual, harmonics, spectra, sliding windows, ranking, before and after."""
    _result(identifier, context)
    page = _page(identifier, context)
    if not page.is_file():
        raise UnknownId("the page is not there any more", where=identifier, remedy="diagnose again")
    return FileResponse(page, media_type="text/html")


@router.post("/{identifier}/adopt", summary="Adopt what it names", status_code=201, responses=ERRORS)
def adopt(identifier: str, body: AdoptBody, response: Response, context: Shared) -> dict[str, Any]:
    """Make the declared model with the named effects a named, versioned model for later fits."""
    result = _result(identifier, context)
    made = context.models.add(
        model_from_diagnosis(
            result, body.name, body.by, context.models,
            recordings=result["recordings"], effects=body.effects, free=body.free, force=body.force,
        )
    )  # fmt: skip
    response.headers["Location"] = f"/models/{made.label}"
    return made.as_json()


def _result(identifier: str, context: Context) -> dict[str, Any]:
    """The result of a diagnosis.  Raises UnknownId, InputError if there is none."""
    job = context.engine.job("diagnosis", identifier)
    if "verdict" not in job.result:
        why = f"it is {job.state}" + (f": {job.error}" if job.error is not None else "")
        remedy = "remove the cause and diagnose anew" if job.state.final else "wait until its state is done"
        raise InputError("the diagnosis has no result", where=identifier, why=why, remedy=remedy)
    return job.result
