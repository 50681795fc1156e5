"""Adopted models: listed, shown with their evidence, retired, never deleted."""

from __future__ import annotations

from fastapi import APIRouter

from platform_daemon import estimation  # not its parts, which load numba
from platform_daemon.schemas import AdoptedModelReport, AdoptedModelSummary, ModelListing, RetirementRequest

from ..context import ModelLabel, Shared
from ..network.routes import GuardedRoute
from ..pages import NEXT, Paged
from ..problems import problems, unreadable

router = APIRouter(prefix="/models", tags=["models"], route_class=GuardedRoute)


@router.get("", summary="Models that a fit can use", responses={**NEXT, **problems(422)})
def list_models(context: Shared, page: Paged) -> ModelListing:
    """Declared models and further torque terms by name; every version of every adopted model, and every file that
    holds none with the reason."""
    models, files = context.models.all()
    adopted, broken = {m.label: m for m in models}, {each.identifier: each for each in files}
    here = set(page.of((*adopted, *(name for name in broken if name not in adopted))))
    return ModelListing(
        declared=tuple(estimation.MODELS),
        terms=tuple(estimation.TERMS),
        adopted=tuple(m.summary() for label, m in adopted.items() if label in here),
        broken=tuple(unreadable(each) for name, each in broken.items() if name in here) or None,
    )


@router.get("/{name}", summary="An adopted model with its evidence", responses=problems(404, 422))
def get_model(name: ModelLabel, context: Shared) -> AdoptedModelReport:
    """NAME@VERSION, or NAME: its newest version that is not retired."""
    return context.models.get(name).report()


@router.post("/{name}/retire", summary="Take a version out of use", responses=problems(404, 415, 422, 507))
def retire_model(name: ModelLabel, body: RetirementRequest, context: Shared) -> AdoptedModelSummary:
    """It stays on disk, and results that used it can be repeated by NAME@VERSION; NAME alone no longer means it."""
    return context.models.retire(name, body.by, body.reason).summary()
