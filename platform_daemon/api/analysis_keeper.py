"""Takes up analyses that wait: what a schedule has asked for, and what waited when the web process ended."""

from __future__ import annotations

import threading
from functools import partial

import structlog

from .context import Context
from .stored_work import work_of

log = structlog.get_logger()
_LOOK_EVERY_S = 1.0


class AnalysisKeeper:
    """In a thread of its own, from now on."""

    def __init__(self, context: Context) -> None:
        self._analyses, self._work_of = context.analyses, partial(work_of, context=context)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="waiting analyses", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Idempotent."""
        self._ended.set()
        self._thread.join(5.0)

    def _run(self) -> None:
        said = ""
        while True:
            try:
                self._analyses.take_up(self._work_of)
                said = ""
            except Exception as error:  # the thread must outlive a bad file; others that wait come next
                if str(error) != said:  # once, not every second
                    log.error("analyses_not_taken_up", error=str(error))
                said = str(error)
            if self._ended.wait(_LOOK_EVERY_S):
                return
