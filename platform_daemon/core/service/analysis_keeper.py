"""Queues analyses that wait: those of schedules, and those that waited when the web process ended."""

from __future__ import annotations

import threading

import structlog

from .analysis_jobs import AnalysisJobs

log = structlog.get_logger()
_LOOK_EVERY_S = 1.0


class AnalysisKeeper:
    """In a thread of its own, from now on."""

    def __init__(self, analyses: AnalysisJobs) -> None:
        self._analyses = analyses
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
                self._analyses.take_up()
                said = ""
            except Exception as error:  # the thread must outlive a bad file; others that wait come next
                if str(error) != said:  # once, not every second
                    log.error("analyses_not_taken_up", error=str(error))
                said = str(error)
            if self._ended.wait(_LOOK_EVERY_S):
                return
