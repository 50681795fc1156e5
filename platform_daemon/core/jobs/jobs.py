"""A job: its request, its progress, its result, and the work that it does."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any, Generic, Protocol, TypeVar

import structlog

from drivers.clock import Clock, SystemClock
from drivers.errors import PlatformError
from platform_daemon.core.schemas.base import ClockKind
from platform_daemon.core.schemas.jobs import JobState, Progress

from .eta import remaining_s
from .shot_log import ShotLog

log = structlog.get_logger()
RESTING_STEP_S = 0.05
_BEGINS_WITHIN_S = 0.05


DAEMON_ENDED = "stopped because the daemon was told to end"
"""The warning of a job that no person has cancelled."""


class Cancelled(Exception):
    """The job was cancelled and has stopped at a safe point."""


RequestT = TypeVar("RequestT")
ResultT = TypeVar("ResultT")


class Work(Protocol[RequestT, ResultT]):
    """What a job does: a series, a fit, a diagnosis.  Checked when made, it begins when called."""

    @property
    def kind(self) -> str:
        """Kind of its job, as in the job's id."""

    @property
    def request(self) -> RequestT:
        """What was requested."""

    @property
    def total(self) -> float:
        """How much there is to do."""

    @property
    def unit(self) -> str:
        """Unit of `total`."""

    @property
    def duration_s(self) -> float | None:
        """How long it takes at least by its plan, s; None: unknown."""

    @property
    def no_result(self) -> ResultT:
        """The result of its job before the work has one."""

    def __call__(self, job: Job[RequestT, ResultT]) -> None:
        """Do the work: report progress by `job.at`, check `job.cancel_requested` at safe points, replace `job.result`.

        Raises Cancelled, PlatformError.
        """


def new_identifier(kind: str, created: datetime, ending: str | None = None) -> str:
    """Id of a job: its kind, the second it was submitted at, UTC, and an ending, None: a random one."""
    return f"{kind}-{created:%Y%m%dT%H%M%S}-{ending or secrets.token_hex(3)}"


@dataclass
class Job(Generic[RequestT, ResultT]):
    """One piece of work.  Its worker thread writes it, any thread may read it.

    request: as checked; result: the result so far, replaced as a whole; question: what the operator has to do before
    the job continues, None: nothing; within: id of the procedure that it is a step of; shots: those on disk, of a
    series of this run of the program; place: in the queue, if a person has put the queue in order, counts before the
    priority; arrival: its number among all jobs that were ever queued, None: it never was; successor: the job that was
    queued in its place after a restart; stays: set when the daemon ends, so that the next one begins the job; reached:
    the largest `done` so far; cut_off: why the job fails, and is not cancelled, if it stops although no person has
    cancelled it; platform_clock: kind of the clock that its shots go by, None: it makes none, or it is not known.
    """

    kind: str
    request: RequestT
    result: ResultT
    total: float
    unit: str
    clock: Clock = field(default_factory=SystemClock)
    identifier: str = ""
    state: JobState = JobState.QUEUED
    phase: str = "waiting"
    done: float = 0.0
    error: Exception | None = None
    warnings: list[str] = field(default_factory=list)
    created: datetime | None = None
    started: datetime | None = None
    finished: datetime | None = None
    cancel_requested: threading.Event = field(default_factory=threading.Event)
    ended: threading.Event = field(default_factory=threading.Event)
    on_change: Callable[[Job[Any, Any]], None] = lambda job: None
    question: str | None = None
    within: str | None = None
    shots: ShotLog = field(default_factory=ShotLog)
    place: int | None = None
    arrival: int | None = None
    successor: Job[Any, Any] | None = None
    stays: threading.Event = field(default_factory=threading.Event)
    proceed: threading.Event = field(default_factory=threading.Event)
    pause_requested: threading.Event = field(default_factory=threading.Event)
    reached: float = 0.0
    cut_off: PlatformError | None = None
    platform_clock: ClockKind | None = None
    _kept: float | None = None
    _planned_s: tuple[float, ...] = ()  # what each unit takes, as planned
    _before: float = 0.0  # what was done when that plan was set
    _started_s: float = 0.0
    _rested_s: float = 0.0
    _rests_since_s: float | None = None
    _lock: threading.RLock = field(default_factory=threading.RLock)

    def __post_init__(self) -> None:
        self.created = self.clock.utc()
        self.identifier = self.identifier or new_identifier(self.kind, self.created)

    @classmethod
    def of(
        cls,
        work: Work[RequestT, ResultT],
        within: AnyJob | None = None,
        again: AnyJob | None = None,
        identifier: str | None = None,
    ) -> Job[RequestT, ResultT]:
        """The job that will do this work.

        within: the procedure that it is a step of, None: of none; again: the job of an earlier run, whose id and time
        it has, and if that one waits its place; identifier: that it will have, None: a new one.
        """
        job = cls(work.kind, work.request, work.no_result, work.total, work.unit, identifier=identifier or "")
        if again is not None:
            job.identifier, job.created = again.identifier, again.created
            job.result, job.done, job._before, job.reached = again.result, again.done, again.done, again.reached
            if not again.state.final:
                job.place, job.arrival, job.cancel_requested = again.place, again.arrival, again.cancel_requested
                if again.pause_requested.is_set():
                    job.pause_requested.set()
        if within is not None:  # one event for both, so that no moment is left in which only one of them is stopped
            job.within = within.identifier
            job.cancel_requested, job.pause_requested = within.cancel_requested, within.pause_requested
        return job

    @property
    def priority(self) -> int:
        """Of those that wait the highest begins first."""
        return getattr(self.request, "priority", 0)

    def begin(self) -> bool:
        """From queued to running; False if it was cancelled before, or is to be, or stays."""
        with self._lock:
            if self.stays.is_set() and self.within is None:
                return False
            if self.cancel_requested.is_set():  # stopped while the one before it ended
                self.request_cancel()
            if self.state is not JobState.QUEUED:
                return False
            self.state, self.started, self._started_s = JobState.RUNNING, self.clock.utc(), self.clock.monotonic_s()
        self.on_change(self)
        return True

    @contextmanager
    def held(self) -> Iterator[bool]:
        """Nothing becomes of it meanwhile; does it wait?"""
        with self._lock:
            yield self.state is JobState.QUEUED and self.successor is None

    @property
    def has_begun(self) -> bool:
        """It runs, is a step, or is to be cancelled; called by a stop of everything, so it waits for no disk."""
        ours = self._lock.acquire(timeout=_BEGINS_WITHIN_S)  # else it is being written
        try:
            queued = self.state is JobState.QUEUED and self.within is None
            return not queued or self.cancel_requested.is_set()
        finally:
            if ours:
                self._lock.release()

    def expect(self, seconds: Sequence[float]) -> None:
        """What each of its units takes from now on, s, as planned: time left follows from that and the pace so far.

        Units beyond are taken to be like these on average.
        """
        with self._lock:
            self._planned_s, self._before = tuple(seconds), self.done
            self._started_s, self._rested_s = self.clock.monotonic_s(), 0.0

    def at(self, done: float, phase: str) -> None:
        """Report progress, which never falls."""
        with self._lock:
            self.done, self.phase = max(self.done, done), phase
            self.reached = max(self.reached, self.done)

    def kept(self, done: float) -> None:
        """So much is kept if it ends before all is done: what was under way then does not count."""
        with self._lock:
            self._kept = done

    def progress(self) -> Progress:
        """How far it is; time left from the plan and the pace so far."""
        with self._lock:
            left = None
            if self._rests_since_s is not None and not self.state.final:
                left = None
            elif self.state is JobState.RUNNING:
                worked_s = self.clock.monotonic_s() - self._started_s - self._rested_s
                left = remaining_s(self._planned_s, self._before, self.done, self.total, worked_s)
            elif self.state.final:
                left = 0.0
            share = min(1.0, max(self.done, self.reached) / self.total) if self.total > 0 else 1.0
            rests = self.state is JobState.QUEUED and self.within is None and self.pause_requested.is_set()
            phase = "paused" if rests else self.phase
            return Progress(
                done=self.done, total=self.total, unit=self.unit, phase=phase, fraction=share, time_left_s=left
            )

    def rest(self, longest_s: float) -> bool:
        """Wait as long as a pause is requested, at most `longest_s`; False if it is requested still.

        Ends at once when the job is to be cancelled.  What is waited here is no part of the pace.
        """
        with self._lock:
            began = self._rests_since_s = self.clock.monotonic_s()
            before, self.phase = self.phase, "paused"
        while self.pause_requested.is_set() and not self.cancel_requested.wait(timeout=RESTING_STEP_S):
            if self.clock.monotonic_s() - began > longest_s:
                break
        with self._lock:
            self._rested_s += self.clock.monotonic_s() - began
            self._rests_since_s, self.phase = None, before
        return self.cancel_requested.is_set() or not self.pause_requested.is_set()

    def ask_pause(self, *, pause: bool) -> bool:
        """Request a pause, or end it; for a waiting job the request is stored.  False: the job has ended."""
        with self._lock:
            if self.successor is not None:
                return self.successor.ask_pause(pause=pause)
            if self.state.final:
                return False
            (self.pause_requested.set if pause else self.pause_requested.clear)()
            self.on_change(self)
            return True

    def ask(self, what: str) -> None:
        """Ask the operator to do something; the job waits until `proceed` is set."""
        self.proceed.clear()
        self.question = what

    def answered(self) -> None:
        """It is done."""
        self.question = None

    def request_cancel(self) -> None:
        """Ask it to stop; a queued job is cancelled at once, a running one at its next safe point."""
        self.cancel_requested.set()
        with self._lock:
            if self.successor is not None:
                self.successor.request_cancel()
            elif self.state is JobState.QUEUED:
                self.end(JobState.CANCELLED)

    def end(self, state: JobState, error: Exception | None = None) -> None:
        """Final state, once."""
        with self._lock:
            if self.state.final:
                return
            self.state, self.error, self.finished, self.phase = state, error, self.clock.utc(), str(state)
            if state is not JobState.DONE and self._kept is not None:
                self.done = self._kept
        self.on_change(self)  # stored before waiting threads are notified
        self.ended.set()

    def run(self, work: Callable[[Job[Any, Any]], None]) -> None:
        """Run `work(self)` and end in done, in cancelled if it raises Cancelled, or in failed with the error.

        One that is cut off has failed with `cut_off`, not been cancelled.
        """
        if not self.begin():
            return
        try:
            work(self)
        except Cancelled:
            self.end(JobState.CANCELLED if self.cut_off is None else JobState.FAILED, self.cut_off)
        except PlatformError as error:
            self.end(JobState.FAILED, error)
        except Exception as error:
            log.error("job_broke", job=self.identifier, exc_info=error)
            what, remedy = f"unexpected {type(error).__name__}", f"report it; the log has it under {self.identifier}"
            self.end(JobState.FAILED, PlatformError(what, why=str(error), remedy=remedy))
        else:
            self.end(JobState.DONE)


AnyJob = Job[Any, Any]
"""A job of whatever kind."""
