"""What on-line fits take long for the first time: loading the estimator's kernels, or compiling them."""

from __future__ import annotations

import threading
from concurrent.futures import Executor

import structlog

from platform_daemon import analysis
from platform_daemon.workers import Computer

from .computed import computed_surely

log = structlog.get_logger()


class WarmFits:
    """Loads them there where on-line fits are made: thread hands them to `computer`.  done: set once they are there."""

    def __init__(self, thread: Executor, computer: Computer) -> None:
        self._thread, self._computer = thread, computer
        self.done = threading.Event()

    def begin(self) -> None:
        """Before the first fit."""
        self._thread.submit(self._load)

    def _load(self) -> None:
        try:
            seconds = computed_surely(self._computer, "planning", analysis.Warmth())
        except Exception as error:  # the first fit will meet the same error and report it
            log.error("warm_up_failed", error=str(error))
            return
        log.info("estimator_warm", seconds=round(seconds, 2))
        self.done.set()
