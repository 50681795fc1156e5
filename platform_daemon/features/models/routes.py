"""Adopted models: listed, shown with their evidence, retired, never deleted."""

from __future__ import annotations

from fastapi import APIRouter

from platform_daemon.core.web.context import ModelLabel, Shared
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.pages import NEXT, Paged
from platform_daemon.core.web.problems import problems, unreadable

from .library import Library
from .schema import AdoptedModelReport, AdoptedModelSummary, ModelListing, RetirementRequest

router = APIRouter(prefix="/models", tags=["models"], route_class=GuardedRoute)


@router.get("", summary="Models that a fit can use", responses={**NEXT, **problems(422)})
def list_models(context: Shared, page: Paged) -> ModelListing:
    """Declared models and further torque terms by name; every version of every adopted model, and every file that
    holds none with the reason."""
    from platform_daemon.estimation.physics.models import MODELS
    from platform_daemon.estimation.physics.torques import TERMS

    models, files = Library(context.folders.models).all()
    adopted, broken = {m.label: m for m in models}, {each.id: each for each in files}
    here = set(page.of((*adopted, *(name for name in broken if name not in adopted))))
    return ModelListing(
        declared=tuple(MODELS),
        terms=tuple(TERMS),
        items=tuple(m.summary() for label, m in adopted.items() if label in here),
        broken=tuple(unreadable(each) for name, each in broken.items() if name in here),
        next=page.next,
    )


@router.get("/{name}", summary="An adopted model with its evidence", responses=problems(404, 422))
def get_model(name: ModelLabel, context: Shared) -> AdoptedModelReport:
    """NAME@VERSION, or NAME: its newest version that is not retired."""
    return Library(context.folders.models).get(name).report()


@router.post("/{name}/retire", summary="Take a version out of use", responses=problems(404, 415, 422, 507))
def retire_model(name: ModelLabel, body: RetirementRequest, context: Shared) -> AdoptedModelSummary:
    """It stays on disk, and results that used it can be repeated by NAME@VERSION; NAME alone no longer means it."""
    return Library(context.folders.models).retire(name, body.by, body.reason).summary()
