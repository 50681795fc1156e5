"""Writes shots to disk in a thread, in order; a few may wait in memory, so that a slow disk makes no shot late."""

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


class BackgroundWriter:
    """Stores one shot after the other, in its own thread.

    After a shot that could not be stored no later one is stored, so that no shot is missing between others.
    """

    def __init__(self) -> None:
        self._disk = ThreadPoolExecutor(max_workers=1, thread_name_prefix="disk")
        self._waiting: deque[Future[Path]] = deque()
        self._failed: BaseException | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._disk.shutdown()  # queued shots are stored however the series ends

    def put(self, store: Callable[[], Path]) -> Future[Path]:
        """Queue a shot and return the future of its file.  Raises the error of an earlier shot that was not stored."""
        self.wait(MOST_AT_ONCE - 1)
        future = self._disk.submit(self._one, store)
        self._waiting.append(future)
        return future

    def wait(self, most: int = 0) -> None:
        """Wait until at most `most` shots are not on disk yet.  Raises the error of a shot that was not stored."""
        while self._waiting and (len(self._waiting) > most or self._waiting[0].done()):
            self._waiting.popleft().result()

    def _one(self, store: Callable[[], Path]) -> Path:
        if self._failed is not None:
            raise self._failed
        try:
            return store()
        except BaseException as error:  # the series raises it with its next shot
            log.error("shot_not_stored", exc_info=error)
            self._failed = error
            raise
