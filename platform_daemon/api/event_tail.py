"""Follows the journal of events once for all listeners, each of which has a place of its own in it.

The journal is the queue: what a listener has not taken costs no memory, and one that is slow holds up nobody.  Whoever
asks for what came before gets all that is kept, in its own time; who then falls more than MOST_BEHIND events behind is
set forward, and told how many it will not get.
"""

from __future__ import annotations

import asyncio
import contextlib
import sqlite3
from collections.abc import AsyncGenerator, Callable
from pathlib import Path

import structlog

from drivers.errors import PlatformError
from platform_daemon.schemas import DroppedEvent, to_json
from platform_daemon.store import EventReader, KeptEvent

log = structlog.get_logger()
MOST_BEHIND = 1000
PAGE = 200
MOST_LISTENERS = 100
"""Each holds a connection for as long as it likes; the other half of them is for all who ask something."""
_LOOK_S = 0.05
_SILENCE_S = 1.0  # of so much it is asked whether who listens still may


class EventTail:
    """For one event loop.  path: of the journal; heard: called before any listener hears of what is new."""

    def __init__(self, path: Path, heard: Callable[[], None] = lambda: None) -> None:
        self._path, self._heard = path, heard
        self._reader: EventReader | None = None
        self._newest, self._listeners = 0, 0
        self._grown = asyncio.Condition()
        self._task: asyncio.Task[None] | None = None
        self._ended = False
        self._last_page: tuple[tuple[int, int, bool], list[KeptEvent]] = (-1, -1, True), []

    @property
    def full(self) -> bool:
        """Do as many listen as may?"""
        return self._listeners >= MOST_LISTENERS

    def close(self) -> None:
        """All listeners are let go, within a moment; from any thread.  Idempotent."""
        self._ended = True

    async def follow(
        self, after: int | None, still: Callable[[], bool] = lambda: True
    ) -> AsyncGenerator[KeptEvent, None]:
        """Events with larger numbers, then those that come; None: only those that come.  Raises StorageError.

        still: asked while nothing happens, False ends it.  One of kind `dropped` stands for those that will not come.
        Nothing at all where as many listen as may.
        """
        if self.full:
            return
        reader = self._reader = self._reader or EventReader(self._path)
        last = reader.newest() if after is None else after
        self._listeners += 1
        if self._task is None:
            self._newest = reader.newest()
            self._task = asyncio.create_task(self._look())
        try:
            last = last or reader.base  # 0: all that is kept
            if not reader.base <= last <= reader.newest():  # of a journal that there is no more
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
        """Until there is more than `last`, or for a moment."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_SILENCE_S), self._grown:
                while self._newest <= last and not self._ended:
                    await self._grown.wait()

    def _page(self, reader: EventReader, last: int, *, live: bool) -> list[KeptEvent]:
        """What comes next for one who has had `last`; most ask for the same, one after the other."""
        asked = last, self._newest, live
        if self._last_page[0] != asked:
            self._last_page = asked, _page(reader, last, live=live)
            if self._last_page[1]:
                self._heard()
        return self._last_page[1]

    async def _look(self) -> None:
        """As long as anybody listens."""
        said = ""
        while self._listeners and not self._ended:
            await asyncio.sleep(_LOOK_S)
            try:
                newest = 0 if self._reader is None else self._reader.newest()
                said = ""
            except (sqlite3.Error, PlatformError) as error:
                if str(error) != said:  # once, not twenty times a second
                    log.error("events_not_read", error=str(error))
                said = str(error)
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
    """What comes next for one who has had `last`; live: nothing that it had asked for is left."""
    begin = max(last, reader.forgotten(), reader.newest() - MOST_BEHIND if live else 0)
    found = list(reader.after(begin, PAGE))
    return found if begin == last else [_dropped(begin, begin - last), *found]


def _dropped(number: int, count: int | None) -> KeptEvent:
    what = to_json(DroppedEvent(count=count))
    return KeptEvent(number, "dropped", f'{{"id":{number},"at":null,"what":{what}}}')
