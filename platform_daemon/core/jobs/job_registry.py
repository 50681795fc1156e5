"""Every job by its id, those of earlier runs too; and which of them hold the hardware, or wait for it."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Collection, Sequence
from concurrent.futures import ThreadPoolExecutor

import structlog

from drivers.errors import InputError, PlatformError
from platform_daemon.core.registry import feature_of
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.state.errors import StorageError

from .events import EventSink, job_event, null_sink
from .hardware_queue import in_turn, is_procedure
from .job_records import JobRecords, cut_off_error, second_of
from .jobs import DAEMON_ENDED, AnyJob

log = structlog.get_logger()
MOST_ENDED = 200
"""Jobs that have ended and are kept in memory; ..."""
_WRITERS = 16
MOST_FITS = 1000
"""... and fits in them, each some 20 KB with all that it refers to; the last job stays however many it has."""


class UnknownId(InputError):
    """No job or recording has that id."""

    title = "Not found"
    http_status = 404


class JobRegistry:
    """The jobs of these kinds.  Written under the lock of its owner, read by any thread.

    tell: takes an event for each change of a job's state; ends: once set, jobs that have not begun wait for the next
    process.
    """

    def __init__(self, journal: JobRecords, kinds: frozenset[str], tell: EventSink = null_sink) -> None:
        self._journal, self._tell = journal, tell
        self._told: dict[str, JobState] = {}  # of jobs that have not ended
        self._lock, self.ends = threading.Lock(), threading.Event()
        self._kinds = kinds
        found = journal.load(kinds, kinds, lambda job: tell(job_event(job)), most=MOST_ENDED)
        self._jobs = {job.identifier: job for job in found}  # those that have not ended, and those that were used last
        others = [each for each in _names(journal, kinds) if each not in self._jobs]
        self._ids = dict.fromkeys(sorted([*others, *self._jobs], key=second_of))
        self._left = [job for job in found if not job.state.final]  # which have not been queued again
        self._arrivals = itertools.count(1 + max((job.arrival or 0 for job in found), default=0))
        self._unsaved: dict[str, AnyJob] = {}  # whose end is not on the disk
        self._ended = {job.identifier: _fits(job) for job in found if job.state.final}  # fits in them
        self._forget_oldest()
        self._moving: list[AnyJob] = []  # wait for the hardware, have it or had it last
        self._conducting: list[AnyJob] = []  # procedures that wait, or make steps

    def add(self, job: AnyJob, *, queued: bool = False) -> None:
        """Keep a job from now on, or one of an earlier run again.

        queued: it wants the hardware, or submits those that do.  Raises StorageError.
        """
        job.stays = self.ends
        if queued and job.arrival is None:
            job.arrival = next(self._arrivals)
        before = self._unsaved.pop(job.identifier, None)  # an earlier end of one that continues
        try:
            self._journal.save(job)
        except StorageError:
            if before is not None:
                self._unsaved[job.identifier] = before
            raise
        self._save_ended()
        job.on_change = self._keep
        # known to `outputs_off` before it can begin
        if queued and not is_procedure(job):
            self._moving = [*(each for each in self._moving if not each.state.final), job]
        elif queued:
            self._conducting = [*(each for each in self._conducting if not each.state.final), job]
        self._jobs[job.identifier] = job
        self._ids[job.identifier] = None
        with self._lock:
            self._ended.pop(job.identifier, None)
        self._tell_state(job)

    def keep(self, job: AnyJob) -> None:
        """A job as it is now, on disk.  Raises StorageError."""
        self._journal.save(job)

    def left_waiting(self) -> list[AnyJob]:
        """Jobs of an earlier run that had not begun and have not been queued again; in the order of the queue."""
        everything = self.all()  # first: what comes meanwhile is queued
        known = {id(job) for job in self.stoppable()}
        found = in_turn(job for job in everything if job.state is JobState.QUEUED and id(job) not in known)
        for job in found:  # also if it is cancelled before it is queued again
            job.on_change = self._keep
        return found

    def found_waiting(self) -> list[AnyJob]:
        """Waiting jobs on disk that are not in the queue, oldest first, including those written after the start."""
        for identifier in [each for each in self._journal.names(self._kinds) if each not in self._ids]:
            self._ids[identifier] = None  # an unreadable one is said once
            job = self._read(identifier)
            if job is not None:
                self._jobs[identifier] = job
                self._left.append(job)
        found, self._left = [job for job in self._left if job.state is JobState.QUEUED], []
        for job in found:
            job.on_change = self._keep
        return found

    def waits_again(self, job: AnyJob) -> None:
        """It could not be queued yet: `found_waiting` finds it once more."""
        self._left.append(job)

    def job(self, kind: str, identifier: str) -> AnyJob:
        """The job of that id.  Raises UnknownId."""
        job = self._jobs.get(identifier)
        if job is None and identifier in self._ids:
            job = self._read(identifier)
        if job is None or job.kind != kind:
            remedy = f"list the {kind}s for the ids that exist"
            raise UnknownId(f"no {kind} has the id {identifier!r}", where=identifier, remedy=remedy)
        return job

    def ids(self, kind: str) -> tuple[str, ...]:
        """Of all jobs of a kind, oldest first; an id begins with it.

        Raises InputError for a kind that no feature has.
        """
        feature_of(kind)
        return tuple(each for each in list(self._ids) if each.partition("-")[0] == kind)

    def ids_in(self, kind: str, states: Collection[JobState]) -> tuple[str, ...]:
        """Of the jobs of a kind that are in one of these states, oldest first; no record is read for it.

        Raises InputError for a kind that no feature has, StorageError where the disk refuses.
        """
        stored = self._journal.ids_in(states)
        jobs = self._jobs

        def matches(identifier: str) -> bool:
            job = jobs.get(identifier)  # what is in memory may be newer than its record
            return identifier in stored if job is None else job.state in states

        return tuple(each for each in self.ids(kind) if matches(each))

    def all(self) -> list[AnyJob]:
        """All jobs that have not ended, and some that have."""
        return list(self._jobs.values())

    def stoppable(self, *, left: bool = False) -> list[AnyJob]:
        """What moves something, or will: procedures first, so that none submits another step; left: of an earlier run
        too."""
        waiting = self.left_waiting() if left else []  # first: one that is queued meanwhile is among the others
        return [*self._conducting, *self._moving, *waiting]

    def begun(self) -> list[AnyJob]:
        """What moves something, steps of it that wait, and what a stop has not come to yet."""
        return [job for job in self.stoppable() if job.has_begun]

    def say_ended(self, killed: str | None = None) -> None:
        """The daemon ends: add a warning to running jobs that no person has cancelled.

        killed: how the daemon was ended, if it was not told to end; what runs has failed then.  A step ends as its
        procedure cancels it.
        """
        for job in self.all():
            if job.state is not JobState.RUNNING or job.cancel_requested.is_set():
                continue
            if killed is None:
                job.warnings.append(DAEMON_ENDED)
            elif job.within is None:
                job.cut_off = cut_off_error(job, killed)

    def cancel(self, jobs: Sequence[AnyJob]) -> None:
        """At once; what runs, if anything does, first."""
        todo = sorted((job for job in jobs if not job.state.final), key=lambda job: job.state is not JobState.RUNNING)
        for job in todo[:1]:
            _cancel(job)
        try:  # each waits for the disk, which syncs many as fast as one: a stop is to be answered within 0.2 s
            with ThreadPoolExecutor(_WRITERS, "cancels") as pool:
                list(pool.map(_cancel, todo[1:]))
        except RuntimeError as error:  # no thread can be had
            log.error("cancelled_in_turn", error=str(error))
            for job in todo[1:]:
                _cancel(job)

    def end_left(self, job: AnyJob, state: JobState, error: PlatformError | None) -> bool:
        """A job of an earlier run will not be done.  False: it has failed because the daemon ends, and waits."""
        if self.ends.is_set() and state is JobState.FAILED:
            return False
        job.on_change = self._keep
        job.end(state, error)
        return True

    @property
    def running(self) -> str | None:
        """Id of the job that has the hardware."""
        return next((j.identifier for j in list(self._moving) if j.state is JobState.RUNNING), None)

    def _tell_state(self, job: AnyJob, *, saved: bool = True) -> None:
        """Once for each state; saved: its record is on the disk."""
        state = job.state
        if self._told.get(job.identifier) is state:
            return
        self._told[job.identifier] = state
        if state.final:
            self._told.pop(job.identifier, None)
            if saved:
                with self._lock:
                    self._ended[job.identifier] = _fits(job)
                self._forget_oldest()
        self._tell(job_event(job))

    def _forget_oldest(self) -> None:
        """Of what has ended and is on disk only so much stays in memory: a job holds the fits of all its shots."""
        with self._lock:
            fits = sum(self._ended.values())
            while self._journal.kept and len(self._ended) > 1 and (len(self._ended) > MOST_ENDED or fits > MOST_FITS):
                oldest = next(iter(self._ended))
                fits -= self._ended.pop(oldest)
                self._jobs.pop(oldest, None)

    def _read(self, identifier: str) -> AnyJob | None:
        try:
            return self._journal.one(identifier)
        except (StorageError, ValueError) as error:
            log.error("job_record_unreadable", job=identifier, error=str(error))
            return None

    @property
    def conducts(self) -> bool:
        """Is a procedure under way that does not rest?"""
        return any(j.state is JobState.RUNNING and not j.pause_requested.is_set() for j in list(self._conducting))

    @property
    def unsaved(self) -> int:
        """Jobs that are cancelled, and the disk does not have it yet."""
        return sum(job.state is JobState.CANCELLED for job in list(self._unsaved.values()))

    def _keep(self, job: AnyJob) -> None:
        saved = True
        try:
            self._journal.save(job)
        # A full disk must not end the thread; the job still answers until the daemon stops.
        except StorageError as error:
            saved = False
            log.error("job_not_saved", job=job.identifier, error=str(error))
            if job.state.final:
                self._unsaved[job.identifier] = job
                self._must_not_wait(job)
        else:
            self._save_ended()
        self._tell_state(job, saved=saved)

    def _must_not_wait(self, job: AnyJob) -> None:
        """In its record the job waits still, and would begin after a restart although it was cancelled."""
        if job.started is None and job.state is JobState.CANCELLED:
            try:
                self._journal.withdraw(job.identifier)
            except StorageError as error:
                log.error("job_not_withdrawn", job=job.identifier, error=str(error))

    def _save_ended(self) -> None:
        """The disk has taken something again: also what it refused."""
        for identifier, job in list(self._unsaved.items()):
            if self._unsaved.get(identifier) is not job:  # it continues
                continue
            try:
                self._journal.save(job)
            except StorageError:
                return
            if self._unsaved.pop(identifier, None) is not None:
                with self._lock:
                    self._ended[identifier] = _fits(job)


def _names(journal: JobRecords, kinds: frozenset[str]) -> list[str]:
    try:
        return journal.names(kinds)
    except StorageError:  # `load` has logged it
        return []


def _cancel(job: AnyJob) -> None:
    try:
        job.request_cancel()
    except Exception as error:  # one unexpected error must not block the other jobs
        log.error("job_not_cancelled", job=job.identifier, exc_info=error)


def _fits(job: AnyJob) -> int:
    fit = getattr(job.result, "fit", None) or job.result
    return len(getattr(fit, "frames", ()))
