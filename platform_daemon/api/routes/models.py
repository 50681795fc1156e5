"""Adopted models: listed, shown with their evidence, retired, never deleted."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter

from platform_daemon.estimation import MODELS, TERMS

from ..context import Shared
from ..models import ProblemModel, RetireBody

router = APIRouter(prefix="/models", tags=["models"])
ERRORS: dict[int | str, dict[str, Any]] = {404: {"model": ProblemModel}, 422: {"model": ProblemModel}}


@router.get("", summary="Models that a fit can use")
def list_models(context: Shared) -> dict[str, Any]:
    """Declared models and further torque terms by name; every version of every adopted model."""
    return {
        "declared": list(MODELS),
        "terms": list(TERMS),
        "adopted": [m.summary() for m in context.models.all()],
    }


@router.get("/{name}", summary="An adopted model with its evidence", responses=ERRORS)
def get_model(name: str, context: Shared) -> dict[str, Any]:
    """NAME@VERSION, or NAME: its newest version that is not retired."""
    found = context.models.get(name)
    return {**found.as_json(), "retired": found.retired}


@router.post("/{name}/retire", summary="Take a version out of use", responses=ERRORS)
def retire_model(name: str, body: RetireBody, context: Shared) -> dict[str, Any]:
    """It stays on disk, and results that used it can be repeated by NAME@VERSION; NAME alone no longer means it."""
    return context.models.retire(name, body.by, body.reason).summary()
