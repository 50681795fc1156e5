"""What waits for the hardware, in the order in which it will have it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from platform_daemon.core.registry import kinds_that_submit_steps

from .jobs import AnyJob


@dataclass
class Waiting:
    """A job and what it does."""

    job: AnyJob
    work: Callable[[AnyJob], None]


class Ended(Exception):
    """No more is to be done."""


def in_turn(jobs: Iterable[AnyJob]) -> list[AnyJob]:
    """Jobs that a person has put in order, in that order; then by falling priority, then by their arrival."""
    return sorted(jobs, key=lambda job: (job.place is None, job.place or 0, -job.priority, job.arrival or 0))


class HardwareQueue:
    """For one that moves the hardware, one that conducts procedures, and any number that put and put in order.

    A procedure begins when the hardware is free for it, and has it first: nothing comes before its first step.
    """

    def __init__(self) -> None:
        self._waiting: list[Waiting] = []
        self._moves = self._ends = False
        self._conducted: AnyJob | None = None
        self._steps_awaited = False  # of the one that is conducted not even the first has begun
        self._changed = threading.Condition()

    def put(self, job: AnyJob, work: Callable[[AnyJob], None]) -> None:
        """Behind those of its priority."""
        with self._changed:
            self._waiting.append(Waiting(job, work))
            self._sort()

    def put_end(self) -> None:
        """Nothing more is begun."""
        with self._changed:
            self._ends = True
            self._changed.notify_all()

    def take(self, timeout_s: float, *, procedures: bool = False) -> Waiting | None:
        """The next one, if it is a procedure or is none; what was taken before has ended then.

        None: within that time none may begin.  Raises Ended.
        """
        until_s = time.monotonic() + timeout_s
        with self._changed:
            if procedures:
                self._conducted, self._steps_awaited = None, False
            else:
                self._moves = False
            self._changed.notify_all()
            while not self._ends:
                found = self._next()
                if found is not None and is_procedure(found.job) is procedures and not (procedures and self._moves):
                    self._begins(found)
                    return found
                left_s = until_s - time.monotonic()
                if left_s <= 0:
                    return None
                self._changed.wait(left_s)
            raise Ended

    @property
    def awaits(self) -> bool:
        """Is there one that will begin by itself?  A paused one lets others go first."""
        with self._changed:
            return self._only() is not None or self._next() is not None

    def jobs(self) -> tuple[AnyJob, ...]:
        """Those that wait, the next one first."""
        with self._changed:
            return tuple(each.job for each in self._waiting if not each.job.state.final)

    def change(self, change: Callable[[tuple[AnyJob, ...]], None]) -> None:
        """Let `change` set places and priorities of the waiting jobs; none is taken from the queue meanwhile."""
        with self._changed:
            change(self.jobs())
            self._sort()

    def exchange(self, job: AnyJob, change: Callable[[], Callable[[AnyJob], None]]) -> bool:
        """Replace the work of a waiting job by what `change` returns; False: the job has begun or ended."""
        with self._changed:
            for each in self._waiting:
                if each.job is job and not job.state.final:
                    each.work = change()
                    self._sort()
                    return True
        return False

    def _sort(self) -> None:
        works = {id(each.job): each for each in self._waiting}
        self._waiting = [works[id(job)] for job in in_turn(each.job for each in self._waiting)]
        self._changed.notify_all()

    def _only(self) -> AnyJob | None:
        """The procedure whose first step comes before all others; None: whatever is next."""
        found = self._conducted if self._steps_awaited else None
        return None if found is None or found.pause_requested.is_set() or found.state.final else found

    def _next(self) -> Waiting | None:
        only = self._only()
        return next((each for each in self._waiting if self._may_begin(each.job, only)), None)

    def _may_begin(self, job: AnyJob, only: AnyJob | None) -> bool:
        if only is not None:
            return job.within == only.identifier
        return not _rests(job) and not (is_procedure(job) and self._conducted is not None)

    def _begins(self, found: Waiting) -> None:
        self._waiting.remove(found)
        if is_procedure(found.job):
            self._conducted, self._steps_awaited = found.job, True
        else:
            self._moves, self._steps_awaited = True, False


def is_procedure(job: AnyJob) -> bool:
    """Whether a job moves nothing itself, but submits others that do."""
    return job.kind in kinds_that_submit_steps()


def _rests(job: AnyJob) -> bool:
    """A step's pause is for its procedure to make; one that is to be cancelled is taken, so that it ends."""
    return job.within is None and job.pause_requested.is_set() and not job.cancel_requested.is_set()
