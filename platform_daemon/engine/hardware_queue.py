"""What waits for the hardware, in the order in which it will have it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .jobs import AnyJob


@dataclass
class Waiting:
    """A job and what it does."""

    job: AnyJob
    work: Callable[[AnyJob], None]


class Ended(Exception):
    """No more is to be done."""


class HardwareQueue:
    """For one that takes, and any number that put and put in order."""

    def __init__(self) -> None:
        self._waiting: list[Waiting] = []
        self._ends = False
        self._changed = threading.Condition()

    def put(self, job: AnyJob, work: Callable[[AnyJob], None]) -> None:
        """Last."""
        with self._changed:
            self._waiting.append(Waiting(job, work))
            self._changed.notify()

    def put_end(self) -> None:
        """After what is queued now."""
        with self._changed:
            self._ends = True
            self._changed.notify()

    def take(self, timeout_s: float) -> Waiting | None:
        """The next one that nobody has paused; None: there is none within that time.  Raises Ended."""
        until_s = time.monotonic() + timeout_s
        with self._changed:
            while True:
                found = next((each for each in self._waiting if self._ends or not _rests(each.job)), None)
                if found is not None:
                    self._waiting.remove(found)
                    return found
                if self._ends:
                    raise Ended
                left_s = until_s - time.monotonic()
                if left_s <= 0:
                    return None
                self._changed.wait(left_s)

    @property
    def awaits(self) -> bool:
        """Is there one that will begin by itself?  A paused one lets others go first."""
        with self._changed:
            return any(not _rests(each.job) for each in self._waiting)

    def jobs(self) -> tuple[AnyJob, ...]:
        """Those that wait, the next one first."""
        with self._changed:
            return tuple(each.job for each in self._waiting if not each.job.state.final)

    def order(self, jobs: Sequence[AnyJob]) -> None:
        """These first, in this order, then all others as they were; what has begun meanwhile is left out."""
        first = {id(job): place for place, job in enumerate(jobs)}
        with self._changed:
            self._waiting.sort(key=lambda each: first.get(id(each.job), len(first)))

    def exchange(self, job: AnyJob, change: Callable[[], Callable[[AnyJob], None]]) -> bool:
        """What a job will do, which `change` makes while nobody takes it; False: it has begun, or ended."""
        with self._changed:
            for each in self._waiting:
                if each.job is job and not job.state.final:
                    each.work = change()
                    return True
        return False


def _rests(job: AnyJob) -> bool:
    """A step's pause is for its procedure to make; one that is to be cancelled is taken, so that it ends."""
    return job.within is None and job.pause_requested.is_set() and not job.cancel_requested.is_set()
