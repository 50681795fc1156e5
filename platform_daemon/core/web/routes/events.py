"""A stream of server-sent events, with a journal behind it."""

from __future__ import annotations

import contextlib
import time
from collections.abc import AsyncIterator
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Query, Request, Response
from fastapi.sse import EventSourceResponse, ServerSentEvent

from drivers.errors import InputError
from platform_daemon.core.schemas.events import Event, EventKind
from platform_daemon.core.state.event_journal import KeptEvent
from platform_daemon.core.web.context import Shared
from platform_daemon.core.web.event_tail import MOST_LISTENERS
from platform_daemon.core.web.network.refusals import Busy
from platform_daemon.core.web.network.routes import GuardedRoute, may_still
from platform_daemon.core.web.problems import problems

router = APIRouter(prefix="/events", tags=["events"], route_class=GuardedRoute)
After = Annotated[int | None, Query(ge=0, le=2**53, description="begin with what came after this number")]
Kinds = Annotated[list[EventKind] | None, Query(max_length=20, description="only these kinds; may be repeated")]
LastId = Annotated[str | None, Header(alias="Last-Event-ID", description="as `after`; a browser sends it by itself")]

_RECHECK_S = 1.0  # a listener may stay for months: its rights are checked again after so long


async def _followed(
    request: Request, response: Response, context: Shared, after: After = None, last_event_id: LastId = None
) -> AsyncIterator[AsyncIterator[KeptEvent]]:
    """The events of one listener, which is released at the end of the request, however that ends: FastAPI leaves the
    generators of a stream whose client does not read to the garbage collector.

    Raises InputError, Busy, before anything is sent.
    """
    if context.events.full:
        remedy = "close pages that are not needed, or poll the jobs every second"
        raise Busy("as many listen to events as may", why=f"{MOST_LISTENERS} do", remedy=remedy)
    asked = _first(after, last_event_id)
    first = context.events.newest() if asked is None else asked
    response.headers["Last-Event-ID"] = str(first)
    followed = context.events.follow(first, lambda: may_still(request))
    async with contextlib.aclosing(followed) as events:
        yield events


def _first(after: int | None, last_event_id: str | None) -> int | None:
    """Raises InputError."""
    if last_event_id is None:
        return after
    if not last_event_id.isdecimal() or len(last_event_id) > 16:
        remedy = "send the `id` of the last event that was received, or leave the header out"
        raise InputError(f"{last_event_id[:50]!r} is no number of an event", where="Last-Event-ID", remedy=remedy)
    return int(last_event_id)


Followed = Annotated[AsyncIterator[KeptEvent], Depends(_followed)]


@router.get("", summary="Listen", response_class=EventSourceResponse, responses=problems(422, 503, 507))
async def listen(request: Request, events: Followed, kind: Kinds = None) -> AsyncIterator[Event]:
    """Server-sent events of jobs, shots, on-line fits, devices, interlock, alarms and schedules.

    `event` is the kind, `id` the number, `data` the JSON of an Event.  Without `after` or `Last-Event-ID` only new
    events are sent; with one of them all that the journal keeps since then (100 000 events).  The header
    `Last-Event-ID` of the answer is the number that the stream begins after: a listener that is cut off before its
    first event misses none if it sends it.  A listener that falls a
    thousand events behind skips to newer ones, after an event of kind `dropped`.  If its token is revoked, the stream
    ends.
    """
    wanted = frozenset(kind) | {"dropped"} if kind else None
    checked_s = time.monotonic()
    async for event in events:
        if time.monotonic() - checked_s > _RECHECK_S:
            if not may_still(request):
                return
            checked_s = time.monotonic()
        if wanted is None or event.kind in wanted:
            sent: Any = ServerSentEvent(raw_data=event.text, event=event.kind, id=str(event.id))
            yield sent
