"""Work by the calendar: add, look, pause, resume, run now, remove; and what became of each start."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Response

from platform_daemon.schemas import (
    LedgerPage,
    LedgerRow,
    Schedule,
    ScheduleListing,
    SchedulePreview,
    ScheduleRequest,
)

from ..context import CONFIRMED, Confirmed, Shared
from ..network.routes import GuardedRoute
from ..pages import NEXT, Paged
from ..problems import OWNER, problems

router = APIRouter(prefix="/schedules", tags=["schedules"], route_class=GuardedRoute, responses=problems(*OWNER))
ScheduleId = Annotated[str, Path(description="id of the schedule, as its POST answered it")]
After = Annotated[int, Query(ge=0, le=2**53, description="rows with larger numbers")]
Limit = Annotated[int, Query(ge=1, le=1000, description="at most so many rows")]
Count = Annotated[int, Query(ge=1, le=1000, description="at most so many instants")]
COMMANDS = problems(404, 409, 415, 422, 507)


@router.post("", summary="Add a schedule", status_code=201, responses=problems(409, 415, 422, 507))
def add_schedule(body: ScheduleRequest, response: Response, context: Shared) -> Schedule:
    """Start a work by an interval, by cron or on dates, from now on.

    The work is planned first: one that the platform cannot do, or that takes longer than the interval, is answered 422.
    """
    made = context.hardware.add_schedule(body)
    response.headers["Location"] = f"/schedules/{made.identifier}"
    return made


@router.get("", summary="All schedules", responses={**NEXT, **problems(422, 507)})
def list_schedules(context: Shared, page: Paged) -> ScheduleListing:
    """All that were not removed, oldest first, page by page: whether they start anything, why not, and when next."""
    found = {each.identifier: each for each in context.hardware.list_schedules()}
    return ScheduleListing(tuple(page.part_of(found).values()))


@router.post("/preview", summary="When a schedule would start", responses=problems(409, 415, 422, 507))
def preview_schedule(body: ScheduleRequest, context: Shared, count: Count = 10) -> SchedulePreview:
    """The first instants in the zone of the trigger, by the same checks; nothing is kept."""
    return SchedulePreview(due=context.hardware.preview_schedule(body, count))


@router.get("/{identifier}", summary="A schedule", responses=problems(404, 507))
def get_schedule(identifier: ScheduleId, context: Shared) -> Schedule:
    """What was asked for, whether it starts anything, why not, and when next."""
    return context.hardware.get_schedule(identifier)


@router.get("/{identifier}/ledger", summary="What became of each start", responses=problems(404, 422, 507))
def get_ledger(identifier: ScheduleId, context: Shared, after: After = 0, limit: Limit = 100) -> LedgerPage:
    """One row per due instant, oldest first, also of a schedule that was removed."""
    return context.hardware.ledger(identifier, after, limit)


@router.post("/{identifier}/pause", summary="Start nothing more", responses=COMMANDS)
def pause_schedule(identifier: ScheduleId, context: Shared, body: Confirmed = CONFIRMED) -> Schedule:
    """What is due from now on is skipped, and stands so in the ledger; what runs goes on."""
    return context.hardware.pause_schedule(identifier)


@router.post("/{identifier}/resume", summary="Start again", responses=COMMANDS)
def resume_schedule(identifier: ScheduleId, context: Shared, body: Confirmed = CONFIRMED) -> Schedule:
    """After a pause, a stop, or too many failures: what is due from now on is started again."""
    return context.hardware.resume_schedule(identifier)


@router.post("/{identifier}/run", summary="Start it once, now", status_code=202, responses=COMMANDS)
def run_schedule(identifier: ScheduleId, context: Shared, body: Confirmed = CONFIRMED) -> LedgerRow:
    """Beside its trigger; 409 while the platform is busy."""
    return context.hardware.run_schedule(identifier)


@router.delete("/{identifier}", summary="Remove", responses=problems(404, 415, 507))
def remove_schedule(identifier: ScheduleId, context: Shared) -> Schedule:
    """It starts nothing any more: `active` is false, `reason` removed, and nothing is due; its ledger stays."""
    return context.hardware.remove_schedule(identifier)
