"""Shots on their way to the disk: in order, and a few at once, so that a slow disk makes no shot late."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import Self

import structlog

log = structlog.get_logger()
MOST_AT_ONCE = 4
"""Shots in memory that are not on the disk yet; the next one waits."""


class Storing:
    """One shot after the other, in a thread of its own.

    After one that the disk did not take no later one is stored, so that none is missing between others.
    """

    def __init__(self) -> None:
        self._disk = ThreadPoolExecutor(max_workers=1, thread_name_prefix="disk")
        self._waiting: deque[Future[Path]] = deque()
        self._failed: BaseException | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._disk.shutdown()  # what was put is stored, whatever ends the series

    def put(self, store: Callable[[], Path]) -> Future[Path]:
        """Store one more; its file comes later.  Raises what kept one before it from being stored."""
        self.wait(MOST_AT_ONCE - 1)
        future = self._disk.submit(self._one, store)
        self._waiting.append(future)
        return future

    def wait(self, most: int = 0) -> None:
        """Until at most so many are not on the disk yet.  Raises what kept one from being stored."""
        while self._waiting and (len(self._waiting) > most or self._waiting[0].done()):
            self._waiting.popleft().result()

    def _one(self, store: Callable[[], Path]) -> Path:
        if self._failed is not None:
            raise self._failed
        try:
            return store()
        except BaseException as error:  # the series hears of it with its next shot
            log.error("shot_not_stored", exc_info=error)
            self._failed = error
            raise
