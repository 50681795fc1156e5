"""What happens, as it happens: server-sent events with a journal behind them."""

from __future__ import annotations

import contextlib
import time
from collections.abc import AsyncIterator
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Header, Query, Request
from fastapi.sse import EventSourceResponse, ServerSentEvent

from drivers.errors import InputError
from platform_daemon.schemas import Event, EventKind
from platform_daemon.store import KeptEvent

from ..context import Shared
from ..event_tail import MOST_LISTENERS
from ..network.refusals import Busy
from ..network.routes import GuardedRoute, may_still
from ..problems import problems

router = APIRouter(prefix="/events", tags=["events"], route_class=GuardedRoute)
After = Annotated[int | None, Query(ge=0, le=2**53, description="begin with what came after this number")]
Kinds = Annotated[list[EventKind] | None, Query(max_length=20, description="only these kinds; may be repeated")]
LastId = Annotated[str | None, Header(alias="Last-Event-ID", description="as `after`; a browser sends it by itself")]

_AGAIN_S = 1.0  # a listener may stay for months: it is looked so often whether it still may


async def _followed(
    request: Request, context: Shared, after: After = None, last_event_id: LastId = None
) -> AsyncIterator[AsyncIterator[KeptEvent]]:
    """What comes for one listener, who is let go of at the end of the request, however that ends: FastAPI leaves the
    generators of a stream whose client does not read to the collector of garbage.

    Raises InputError, Busy, before anything is sent.
    """
    if context.events.full:
        remedy = "close pages that nobody looks at, or ask for the jobs every second"
        raise Busy("as many listen to events as may", why=f"{MOST_LISTENERS} do", remedy=remedy)
    followed = context.events.follow(_first(after, last_event_id), lambda: may_still(request))
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
    """Server-sent events: jobs, shots, on-line fits, devices, interlock, alarms, schedules.

    `event` is the kind, `id` the number, `data` the JSON of an Event.  Without `after` or `Last-Event-ID` only what
    comes; with it all that the journal keeps since then (100 000 events).  A listener that falls a thousand events
    behind is set forward and told so by an event of kind `dropped`.  One whose token is revoked is let go.
    """
    wanted = frozenset(kind) | {"dropped"} if kind else None
    asked = time.monotonic()
    async for event in events:
        if time.monotonic() - asked > _AGAIN_S:
            if not may_still(request):
                return
            asked = time.monotonic()
        if wanted is None or event.kind in wanted:
            sent: Any = ServerSentEvent(raw_data=event.text, event=event.kind, id=str(event.id))
            yield sent
