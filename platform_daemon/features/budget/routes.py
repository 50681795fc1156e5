"""The uncertainty budget of a stored recording."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Response

from platform_daemon.core.jobs.workers.task_executor import Call
from platform_daemon.core.recordings.index import resolve
from platform_daemon.core.schemas.base import NamedWindow
from platform_daemon.core.web.context import RecordingId, Shared
from platform_daemon.core.web.costs import check_file
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.problems import problems
from platform_daemon.core.web.ranged_file import PNG
from platform_daemon.features.models.library import Library

from .schema import BudgetReport
from .stored import stored_budget

router = APIRouter(prefix="/recordings", tags=["recordings"], route_class=GuardedRoute)


Quantity = Annotated[str, Query(min_length=1, max_length=100, description="parameter")]
Shot = Annotated[int | None, Query(ge=0, description="one frame, from 0; default: the mean of the series")]
Coverage = Annotated[float, Query(gt=0, lt=1, description="probability of the interval")]
Variant = Annotated[str | None, Query(min_length=1, max_length=100)]


@router.get("/{identifier}/budget", summary="Uncertainty budget", responses=problems(404, 422, 423))
def get_budget(
    identifier: RecordingId,
    context: Shared,
    quantity: Quantity = "f_nat_hz",
    shot: Shot = None,
    coverage: Coverage = 0.95,
    window: NamedWindow = "d30",
    variant: Variant = None,
) -> BudgetReport:
    """What each influence contributes to the uncertainty of a parameter, and which influences are not declared."""
    path = resolve(context.folders.recordings, identifier)
    check_file(path)
    how = (path, quantity, shot, coverage, window, variant, Library(context.folders.models))
    return context.run(Call(stored_budget, how))


@router.get(
    "/{identifier}/budget/picture",
    summary="Uncertainty budget as a picture",
    response_class=Response,
    responses={**PNG, **problems(404, 422, 423)},
)
def draw_budget(
    identifier: RecordingId,
    context: Shared,
    quantity: Quantity = "f_nat_hz",
    shot: Shot = None,
    coverage: Coverage = 0.95,
    window: NamedWindow = "d30",
    variant: Variant = None,
) -> Response:
    """PNG: a bar for each contribution, the largest on top."""
    from .report import budget_png

    found = get_budget(identifier, context, quantity, shot, coverage, window, variant)
    return Response(budget_png(found), media_type="image/png")
