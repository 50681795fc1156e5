"""Work by the calendar: add, look, pause, resume, run now, remove; and what became of each start."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Query, Response

from platform_daemon.core.web.context import CONFIRMED, Confirmed, Context, Shared
from platform_daemon.core.web.network.routes import GuardedRoute
from platform_daemon.core.web.pages import NEXT, Paged
from platform_daemon.core.web.problems import OWNER, problems

from .calendar import cron_in_words
from .contract import ScheduleService
from .schema import LedgerPage, LedgerRow, Schedule, ScheduleListing, SchedulePreview, ScheduleRequest

router = APIRouter(prefix="/schedules", tags=["schedules"], route_class=GuardedRoute, responses=problems(*OWNER))
ScheduleId = Annotated[str, Path(description="id of the schedule, as its POST answered it")]
After = Annotated[int, Query(ge=0, le=2**53, description="rows with larger numbers")]
Limit = Annotated[int, Query(ge=1, le=1000, description="at most so many rows")]
Count = Annotated[int, Query(ge=1, le=1000, description="at most so many instants")]


def schedules(context: Context) -> ScheduleService:
    """The schedules of the hardware process."""
    found: ScheduleService = context.feature_service("schedules")
    return found


COMMANDS = problems(404, 409, 415, 422, 507)


@router.post("", summary="Add a schedule", status_code=201, responses=problems(409, 415, 422, 507))
def add_schedule(body: ScheduleRequest, response: Response, context: Shared) -> Schedule:
    """Start a work by an interval, by cron or on dates, from now on.

    The work is planned first: one that the platform cannot do, or that takes longer than the interval, is answered 422.
    """
    made = schedules(context).add(body)
    response.headers["Location"] = f"/schedules/{made.id}"
    return made


@router.get("", summary="All schedules", responses={**NEXT, **problems(422, 507)})
def list_schedules(context: Shared, page: Paged) -> ScheduleListing:
    """All that were not removed, oldest first, page by page: whether they start anything, why not, and when next."""
    found = {each.id: each for each in schedules(context).list()}
    return ScheduleListing(items=tuple(page.part_of(found).values()), next=page.next)


@router.post("/preview", summary="When a schedule would start", responses=problems(409, 415, 422, 507))
def preview_schedule(body: ScheduleRequest, context: Shared, count: Count = 10) -> SchedulePreview:
    """The first instants in the zone of the trigger, by the same checks; nothing is kept."""
    due = schedules(context).preview(body, count)
    return SchedulePreview(due=due, cron_in_words=cron_in_words(body.trigger))


@router.get("/{identifier}", summary="A schedule", responses=problems(404, 507))
def get_schedule(identifier: ScheduleId, context: Shared) -> Schedule:
    """The request of the schedule, whether it starts anything, why not, and when next."""
    return schedules(context).get(identifier)


@router.get("/{identifier}/ledger", summary="What became of each start", responses=problems(404, 422, 507))
def get_ledger(identifier: ScheduleId, context: Shared, after: After = 0, limit: Limit = 100) -> LedgerPage:
    """One row per due instant, oldest first, also of a schedule that was removed.

    A recording of a resonator that is calibrated as a sensor has what it reads.
    """
    from .readings import with_readings

    found = schedules(context).page(identifier, after, limit)
    return with_readings(found, context.folders.recordings, context.folders.measurands)


@router.post("/{identifier}/pause", summary="Start nothing more", responses=COMMANDS)
def pause_schedule(identifier: ScheduleId, context: Shared, body: Confirmed = CONFIRMED) -> Schedule:
    """Starts that become due are skipped, and are listed so in the ledger; running jobs continue."""
    return schedules(context).pause(identifier)


@router.post("/{identifier}/resume", summary="Start again", responses=COMMANDS)
def resume_schedule(identifier: ScheduleId, context: Shared, body: Confirmed = CONFIRMED) -> Schedule:
    """After a pause, a stop, or too many failures: what is due from now on is started again."""
    return schedules(context).resume(identifier)


@router.post("/{identifier}/run", summary="Start it once, now", status_code=202, responses=COMMANDS)
def run_schedule(identifier: ScheduleId, context: Shared, body: Confirmed = CONFIRMED) -> LedgerRow:
    """In addition to its trigger; 409 while the platform is busy."""
    return schedules(context).run(identifier)


@router.delete("/{identifier}", summary="Remove", responses=problems(404, 415, 507))
def remove_schedule(identifier: ScheduleId, context: Shared) -> Schedule:
    """It starts nothing any more: `active` is false, `reason` removed, and nothing is due; its ledger stays."""
    return schedules(context).remove(identifier)
