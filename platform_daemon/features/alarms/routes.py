"""Routes of the alarms, and the metrics for Prometheus."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Response
from prometheus_client import CONTENT_TYPE_LATEST

from platform_daemon.core.web.context import Shared
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.pages import NEXT, Paged
from platform_daemon.core.web.problems import problems

from .board import AlarmBoard
from .schema import Acknowledgement, Alarm, AlarmListing

router = APIRouter(tags=["alarms"], route_class=GuardedRoute)
Name = Annotated[str, Path(description="name of the alarm, as GET /alarms shows it", examples=["disk"])]
TEXT = {"schema": {"type": "string"}}


@router.get("/alarms", summary="List the alarms", responses={**NEXT, **problems(422)})
def list_alarms(context: Shared, page: Paged) -> AlarmListing:
    """Active alarms, the oldest first, then the last hundred that are over; page by page."""
    found = {each.name: each for each in context.part(AlarmBoard).all()}
    return AlarmListing(items=tuple(page.part_of(found).values()), next=page.next)


@router.post(
    "/alarms/{name:path}/acknowledge", summary="Acknowledge an alarm", responses=problems(404, 409, 415, 422, 507)
)
def acknowledge_alarm(name: Name, body: Acknowledgement, context: Shared) -> Alarm:
    """Acknowledge an alarm.  It stays active until its cause is over; 409 if it is over already."""
    return context.part(AlarmBoard).acknowledge(name, body.by)


@router.get(
    "/metrics",
    summary="Numbers for Prometheus",
    response_class=Response,
    responses={200: {"content": {"text/plain": TEXT}, "description": "Text format of Prometheus"}},
)
def get_metrics(context: Shared) -> Response:
    """Jobs, shots, fits, rows of ledgers since the web process began; queue, interlock, alarms, disk as they are."""
    return Response(context.metrics.text(), media_type=CONTENT_TYPE_LATEST)
