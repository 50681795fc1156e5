"""How many requests that compute run at once: memory and cores are taken by few, the others wait outside."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from .access import Takes
from .limits import Limits
from .refusals import Busy


class Lane:
    """So many at once; so many more wait, and not for ever."""

    def __init__(self, at_once: int, waiting: int, patience_s: float) -> None:
        self._free = asyncio.Semaphore(at_once)
        self._most, self._patience_s = waiting, patience_s
        self._waiting = 0

    @asynccontextmanager
    async def taken(self) -> AsyncIterator[None]:
        """A place in it.  Raises Busy."""
        if self._waiting >= self._most:
            raise _busy(f"{self._waiting} requests of this kind wait already")
        self._waiting += 1
        try:
            async with asyncio.timeout(self._patience_s):
                await self._free.acquire()
        except TimeoutError:
            raise _busy(f"those before it took longer than {self._patience_s:g} s") from None
        finally:
            self._waiting -= 1
        try:
            yield
        finally:
            self._free.release()


class Lanes:
    """One for each kind of work."""

    def __init__(self, limits: Limits) -> None:
        waiting, patience = limits.waiting, limits.patience_s
        self.computing = Lane(limits.computing, waiting, patience)
        self.converting = Lane(limits.converting, waiting, patience)
        self.reading = Lane(limits.reading, waiting, patience)
        self.downloading = Lane(limits.downloading, waiting, patience)

    @asynccontextmanager
    async def for_answer(self, takes: Takes) -> AsyncIterator[None]:
        """Held until the answer has left.  Raises Busy."""
        if takes is Takes.DOWNLOAD:
            async with self.downloading.taken():
                yield
        else:
            yield

    @asynccontextmanager
    async def for_work(self, takes: Takes) -> AsyncIterator[None]:
        """Held while the answer is made.  Raises Busy."""
        lanes = {
            Takes.READING: self.reading,
            Takes.COMPUTING: self.computing,
            Takes.DOWNLOAD: self.converting,
        }
        if takes is Takes.NOTHING:
            yield
            return
        async with lanes[takes].taken():
            yield


def too_many_previews() -> Busy:
    """All processes that compute what requests wait for have been busy for too long."""
    return _busy("those before it take too long")


def _busy(why: str) -> Busy:
    return Busy("the server is busy with requests like this one", why=why, remedy="ask again in some seconds")
