"""What takes long the first time, before the first on-line fit: loading the estimator's kernels, or compiling them."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from concurrent.futures import Executor

import structlog

from platform_daemon.core.jobs.run_task import run_task_with_retry
from platform_daemon.core.jobs.workers.task_executor import Task, TaskExecutor

log = structlog.get_logger()
AGAIN_S = 5.0


class WarmUp:
    """Runs the task that `make_task` makes where on-line fits are computed: `thread` hands it to `executor`.

    done: set once it has run.

    What fails is tried again: on a slow executor compiling takes longer than one work may, and what has been compiled
    until then is kept.
    """

    def __init__(self, thread: Executor, executor: TaskExecutor, make_task: Callable[[], Task[float]]) -> None:
        self._thread, self._computer = thread, executor
        self._make_task = make_task
        self.done, self._said = threading.Event(), ""

    def begin(self) -> None:
        """Before the first fit."""
        self._thread.submit(self._load)

    def _again(self) -> None:
        with contextlib.suppress(RuntimeError):  # it is ending
            self.begin()

    def _load(self) -> None:
        try:
            seconds = run_task_with_retry(self._computer, "planning", self._make_task())
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
