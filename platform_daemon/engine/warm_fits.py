"""What on-line fits take long for the first time: loading the estimator's kernels, or compiling them."""

from __future__ import annotations

import contextlib
import threading
from concurrent.futures import Executor

import structlog

from platform_daemon import analysis
from platform_daemon.workers import Computer

from .computed import computed_surely

log = structlog.get_logger()
AGAIN_S = 5.0


class WarmFits:
    """Loads them there where on-line fits are made: thread hands them to `computer`.  done: set once they are there.

    What fails is tried again: on a slow computer compiling takes longer than one work may, and what has been compiled
    until then is kept.
    """

    def __init__(self, thread: Executor, computer: Computer) -> None:
        self._thread, self._computer = thread, computer
        self.done, self._said = threading.Event(), ""

    def begin(self) -> None:
        """Before the first fit."""
        self._thread.submit(self._load)

    def _again(self) -> None:
        with contextlib.suppress(RuntimeError):  # it is ending
            self.begin()

    def _load(self) -> None:
        try:
            seconds = computed_surely(self._computer, "planning", analysis.Warmth())
        except Exception as error:
            if str(error) != self._said:  # once
                log.error("warm_up_failed", error=str(error), again_every_s=AGAIN_S)
            self._said = str(error)
            again = threading.Timer(AGAIN_S, self._again)
            again.daemon = True
            again.start()
            return
        log.info("estimator_warm", seconds=round(seconds, 2))
        self.done.set()
