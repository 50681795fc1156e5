"""The stream of events, which resumes by itself and misses none in silence."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncGenerator, Collection

import httpx2

from platform_daemon.client import answers
from platform_daemon.client.errors import EventsDropped, Unavailable
from platform_daemon.core.schemas.events import DroppedEvent, Event, JobEvent

from .transport import AsyncTransport


async def follow(
    transport: AsyncTransport, *, job: str | None, kinds: Collection[str], after: int | None
) -> AsyncGenerator[Event, None]:
    """See AsyncClient.events.  A stream that is cut off is continued if the daemon is back within PATIENCE_S."""
    last, until_s = after, time.monotonic() + answers.PATIENCE_S
    while True:
        headers, listens = {} if last is None else {"Last-Event-ID": str(last)}, False
        try:
            async with transport.stream("listen", headers, {"kind": tuple(kinds)}) as response:
                listens = True
                begins = response.headers.get("Last-Event-ID", "")
                last = int(begins) if last is None and begins.isdecimal() else last
                async for sent in httpx2.EventSource(response):
                    event = answers.value_from(sent.data, Event, str(response.request.url))
                    if isinstance(event.what, DroppedEvent) and last != 0:  # 0: all that is kept, and no more
                        raise EventsDropped(event.what.count, event.id)
                    last = event.id
                    if job is None or is_of(event, job):
                        yield event
                    if job is not None and ends(event, job):
                        return
        except (httpx2.TransportError, Unavailable) as error:
            if listens:  # it may have been silent for hours
                until_s = time.monotonic() + answers.PATIENCE_S
            elif time.monotonic() < until_s:
                pass
            elif isinstance(error, Unavailable):
                raise
            else:
                raise transport.connection_failed(error, "listen") from None
        if last is None and listens:  # a proxy has taken the number away that the stream began after
            raise EventsDropped(None, 0)
        await asyncio.sleep(answers.FIRST_WAIT_S)


def is_of(event: Event, job: str) -> bool:
    """Whether an event is of that job, or of one of its steps."""
    return job in (getattr(event.what, "job", None), getattr(event.what, "within", None))


def ends(event: Event, job: str) -> bool:
    """Whether that job has ended with this event."""
    return isinstance(event.what, JobEvent) and event.what.job == job and event.what.state.final
