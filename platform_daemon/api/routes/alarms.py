"""What somebody should know, and numbers for those who watch many things."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Response
from prometheus_client import CONTENT_TYPE_LATEST

from platform_daemon.schemas import Acknowledgement, Alarm, AlarmListing

from ..context import Shared
from ..network.routes import GuardedRoute
from ..pages import NEXT, Paged
from ..problems import problems

router = APIRouter(tags=["alarms"], route_class=GuardedRoute)
Name = Annotated[str, Path(description="name of the alarm, as GET /alarms shows it", examples=["disk"])]
TEXT = {"schema": {"type": "string"}}


@router.get("/alarms", summary="What somebody should know", responses={**NEXT, **problems(422)})
def list_alarms(context: Shared, page: Paged) -> AlarmListing:
    """Alarms that stand, the oldest first, then the last hundred that are over; page by page."""
    found = {each.name: each for each in context.alarms.all()}
    return AlarmListing(tuple(page.part_of(found).values()))


@router.post("/alarms/{name:path}/acknowledge", summary="Somebody knows", responses=problems(404, 409, 415, 422, 507))
def acknowledge_alarm(name: Name, body: Acknowledgement, context: Shared) -> Alarm:
    """Say who knows of it.  It stands until what it is about is over; 409 if that is so already."""
    return context.alarms.acknowledge(name, body.by)


@router.get(
    "/metrics",
    summary="Numbers for Prometheus",
    response_class=Response,
    responses={200: {"content": {"text/plain": TEXT}, "description": "Text format of Prometheus"}},
)
def get_metrics(context: Shared) -> Response:
    """Jobs, shots, fits, rows of ledgers since the web process began; queue, interlock, alarms, disk as they are."""
    return Response(context.metrics.text(), media_type=CONTENT_TYPE_LATEST)
