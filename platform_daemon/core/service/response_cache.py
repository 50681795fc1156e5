"""Caches of answers of the hardware process: fifty clients that poll cost it no more than one."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from typing import Any

from .job_view import JobView

RECENT_S = 0.05
MOST_ENDED = 50  # jobs, each with the fits of all its shots


class ResponseCache:
    """Answers of the last 50 ms by question; one asks while the others wait for its answer."""

    def __init__(self) -> None:
        self._answers: dict[tuple[Any, ...], tuple[float, Any]] = {}
        self._asking: dict[tuple[Any, ...], threading.Lock] = {}
        self._lock = threading.Lock()
        self._generation = 0

    def answer(self, question: tuple[Any, ...], ask: Callable[[], Any]) -> Any:
        """That of a moment ago, or what `ask` brings now.  Raises what `ask` raises."""
        with self._lock:
            asking = self._asking.setdefault(question, threading.Lock())
        with asking:
            known = self._answers.get(question)
            if known is not None and time.monotonic() - known[0] < RECENT_S:
                return known[1]
            generation, since_s = self._generation, time.monotonic()
            found = ask()
            with self._lock:
                self._forget_old(since_s)
                if generation == self._generation:  # else it may be of before a command
                    self._answers[question] = since_s, found
            return found

    def invalidate(self) -> None:
        """A command was given: nothing is as it was."""
        with self._lock:
            self._generation += 1
            self._answers.clear()

    def _forget_old(self, now_s: float) -> None:
        for question, (since_s, _) in list(self._answers.items()):
            if now_s - since_s > RECENT_S:
                del self._answers[question]
        for question in [q for q, lock in self._asking.items() if q not in self._answers and not lock.locked()]:
            del self._asking[question]


class FinishedJobCache:
    """The last fifty jobs that have ended; they do not change unless an operator resumes them."""

    def __init__(self) -> None:
        self._jobs: OrderedDict[tuple[str, str], JobView] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, kind: str, identifier: str) -> JobView | None:
        """None: it has not ended, or is not in the cache."""
        with self._lock:
            job = self._jobs.get((kind, identifier))
            if job is not None:
                self._jobs.move_to_end((kind, identifier))
            return job

    def forget(self, kind: str, identifier: str) -> None:
        """It may be resumed."""
        with self._lock:
            self._jobs.pop((kind, identifier), None)

    def keep(self, job: JobView) -> None:
        """If it has ended."""
        if not job.state.final:
            return
        with self._lock:
            self._jobs[job.kind, job.identifier] = job
            while len(self._jobs) > MOST_ENDED:
                self._jobs.popitem(last=False)
