"""How many requests that compute run at once: few of them take memory and cores, the others wait for their turn."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from .access import Takes
from .limits import Limits
from .refusals import Busy


class ConcurrencyLimiter:
    """Lets a number of requests run at once and a number of further ones wait, for a limited time."""

    def __init__(self, running: int, *, max_waiting: int, patience_s: float) -> None:
        self._free = asyncio.Semaphore(running)
        self._max_waiting = max_waiting
        self._patience_s = patience_s
        self._waiting = 0

    @asynccontextmanager
    async def acquired(self) -> AsyncIterator[None]:
        """Wait for a place and hold it.  Raises Busy."""
        if self._waiting >= self._max_waiting:
            raise _busy(f"{self._waiting} requests of this kind wait already")
        self._waiting += 1
        try:
            async with asyncio.timeout(self._patience_s):
                await self._free.acquire()
        except TimeoutError:
            raise _busy(f"the requests before it took longer than {self._patience_s:g} s") from None
        finally:
            self._waiting -= 1
        try:
            yield
        finally:
            self._free.release()


class ConcurrencyLimits:
    """One limiter for each kind of work."""

    def __init__(self, limits: Limits) -> None:
        def limiter(running: int) -> ConcurrencyLimiter:
            return ConcurrencyLimiter(running, max_waiting=limits.waiting, patience_s=limits.patience_s)

        self._work = {
            Takes.READING: limiter(limits.reading),
            Takes.COMPUTING: limiter(limits.computing),
            Takes.DOWNLOAD: limiter(limits.converting),
        }
        self._downloading = limiter(limits.downloading)

    @asynccontextmanager
    async def for_answer(self, takes: Takes) -> AsyncIterator[None]:
        """Held until the answer has been sent.  Raises Busy."""
        if takes is not Takes.DOWNLOAD:
            yield
            return
        async with self._downloading.acquired():
            yield

    @asynccontextmanager
    async def for_work(self, takes: Takes) -> AsyncIterator[None]:
        """Held while the answer is made.  Raises Busy."""
        if takes is Takes.NOTHING:
            yield
            return
        async with self._work[takes].acquired():
            yield


def _busy(why: str) -> Busy:
    return Busy("the server is busy with requests like this one", why=why, remedy="repeat the request in some seconds")
