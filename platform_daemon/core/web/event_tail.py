"""Follows the journal of events once for all listeners, each of which has a position of its own in it.

The journal is the queue: events that a listener has not read yet take no memory, and a slow listener delays no other.
A listener that asks for earlier events gets all that are kept, at its own speed.  After that, one that falls more
than MOST_BEHIND events behind skips to newer ones, and receives an event `dropped` with the number that it missed.
"""

from __future__ import annotations

import asyncio
import contextlib
import sqlite3
from collections.abc import AsyncGenerator, Callable
from pathlib import Path

import structlog

from drivers.errors import PlatformError
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.events import DroppedEvent
from platform_daemon.core.state.event_journal import EventReader, KeptEvent

log = structlog.get_logger()
MOST_BEHIND = 1000
PAGE = 200
MOST_LISTENERS = 100
"""Each holds a connection as long as it likes; half of all connections are left to other requests."""
_POLL_S = 0.02  # an event waits half of it; while somebody listens it takes 0.8 % of a core more than 0.05 does
_RECHECK_S = 1.0  # of silence, after which the rights of the listener are checked again


class EventTail:
    """For one event loop.  path: of the journal; heard: is called before a listener receives new events."""

    def __init__(self, path: Path, heard: Callable[[], None] = lambda: None) -> None:
        self._path = path
        self._heard = heard
        self._reader: EventReader | None = None
        self._newest = 0
        self._listeners = 0
        self._grown = asyncio.Condition()
        self._task: asyncio.Task[None] | None = None
        self._ended = False
        self._last_page: tuple[tuple[int, int, bool], list[KeptEvent]] = (-1, -1, True), []

    @property
    def full(self) -> bool:
        """Are there as many listeners as may be?"""
        return self._listeners >= MOST_LISTENERS

    def newest(self) -> int:
        """Number of the newest event.  Raises StorageError."""
        self._reader = self._reader or EventReader(self._path)
        return self._reader.newest()

    def close(self) -> None:
        """End the streams of all listeners; from any thread.  Idempotent."""
        self._ended = True

    async def follow(
        self, after: int | None, still: Callable[[], bool] = lambda: True
    ) -> AsyncGenerator[KeptEvent, None]:
        """Events with numbers larger than `after`, then new ones; None: only new ones.  Raises StorageError.

        still: is called while there are no events; False ends the stream.  An event of kind `dropped` replaces events
        that are skipped.  Without events at all where `full`.
        """
        if self.full:
            return
        reader = self._reader = self._reader or EventReader(self._path)
        last = reader.newest() if after is None else after
        self._listeners += 1
        if self._task is None:
            self._newest = reader.newest()
            self._task = asyncio.create_task(self._poll())
        try:
            last = last or reader.base  # 0: all that is kept
            if not reader.base <= last <= reader.newest():  # numbers of an earlier journal
                last = reader.base
                yield _dropped(last, None)
            before = reader.newest()
            while not self._ended:
                for event in self._page(reader, last, live=last >= before):
                    last = event.id
                    yield event
                while self._newest <= last and not self._ended:
                    await self._more(last)
                    if self._newest <= last and not still():
                        return
        finally:
            self._listeners -= 1

    async def _more(self, last: int) -> None:
        """Wait for an event after `last`, for a moment at most."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_RECHECK_S), self._grown:
                while self._newest <= last and not self._ended:
                    await self._grown.wait()

    def _page(self, reader: EventReader, last: int, *, live: bool) -> list[KeptEvent]:
        """The events after `last`; most listeners ask for the same ones in turn, so that the last page is cached."""
        key = last, self._newest, live
        if self._last_page[0] != key:
            self._last_page = key, _page(reader, last, live=live)
            if self._last_page[1]:
                self._heard()
        return self._last_page[1]

    async def _poll(self) -> None:
        """Look for new events as long as there are listeners."""
        logged = ""
        while self._listeners and not self._ended:
            await asyncio.sleep(_POLL_S)
            try:
                newest = 0 if self._reader is None else self._reader.newest()
                logged = ""
            except (sqlite3.Error, PlatformError) as error:
                if str(error) != logged:  # once, not at each look
                    log.error("events_not_read", error=str(error))
                logged = str(error)
                continue
            if newest > self._newest:
                async with self._grown:
                    self._newest = newest
                    self._grown.notify_all()
        self._task = None
        if self._ended:
            async with self._grown:
                self._grown.notify_all()
        elif self._reader is not None:
            self._reader.close()
            self._reader = None


def _page(reader: EventReader, last: int, *, live: bool) -> list[KeptEvent]:
    """The events after `last`; live: the listener has received all earlier events that it requested."""
    begin = max(last, reader.forgotten(), reader.newest() - MOST_BEHIND if live else 0)
    found = list(reader.after(begin, PAGE))
    return found if begin == last else [_dropped(begin, begin - last), *found]


def _dropped(number: int, count: int | None) -> KeptEvent:
    what = to_json(DroppedEvent(count=count))
    return KeptEvent(number, "dropped", f'{{"id":{number},"at":null,"what":{what}}}')
