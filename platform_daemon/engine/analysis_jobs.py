"""Work on what is stored, as jobs: fits, diagnoses, characterisations; in one thread, one after the other."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import structlog

from drivers.errors import PlatformError
from platform_daemon.schemas import JobState
from platform_daemon.store import StorageError
from platform_daemon.workers import Computer

from .asked import ShuttingDown
from .happenings import Tell, quiet
from .job_records import JobRecords
from .job_registry import ANALYSES, JobRegistry
from .jobs import AnyJob, Job, RequestT, ResultT, Work

log = structlog.get_logger()


class AnalysisJobs:
    """Takes and keeps them.  computer: does what they compute; cancelled, its process is killed."""

    def __init__(self, computer: Computer, journal: JobRecords | None = None, tell: Tell = quiet) -> None:
        self.computer = computer
        self._registry = JobRegistry(journal or JobRecords(None), ANALYSES, tell)
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="analyses")
        self._lock, self._closed, self._refused = threading.Lock(), self._registry.ends, ""

    def analyse(self, work: Work[RequestT, ResultT]) -> Job[RequestT, ResultT]:
        """Queue it.  Raises ShuttingDown."""
        with self._lock:
            if self._closed.is_set():
                raise ShuttingDown("the daemon is shutting down", remedy="start it again, then ask anew")
            return self._queued(work)

    def take_up(self, make: Callable[[Any], Work[Any, Any]]) -> None:
        """Queue those that wait and that nobody has queued: of an earlier run, or put there by another process.

        make: the work of a request; one that cannot be made any more is failed with the reason.
        """
        with self._lock:  # one that is asked for now is on the disk before it is known
            found = self._registry.found_waiting()
        for job in found:
            try:
                work = make(job.request)
                with self._lock, job.held() as waits:
                    if self._closed.is_set() or not waits:
                        continue
                    job.successor = self._queued(work, job)
                log.info("job_taken_up", job=job.identifier)
            except StorageError as error:
                self._registry.waits_again(job)
                if str(error) != self._refused:  # said once
                    self._refused = str(error)
                    log.warning("job_waits", job=job.identifier, error=self._refused)
            except PlatformError as error:
                log.error("job_not_taken_up", job=job.identifier, error=str(error))
                self._registry.end_left(job, JobState.FAILED, error)

    def _queued(self, work: Work[RequestT, ResultT], again: AnyJob | None = None) -> Job[RequestT, ResultT]:
        job = Job.of(work, again=again)
        self._registry.add(job)
        self._thread.submit(job.run, work)
        return job

    def job(self, kind: str, identifier: str) -> AnyJob:
        """The job of that id.  Raises UnknownId."""
        return self._registry.job(kind, identifier)

    def job_ids(self, kind: str) -> tuple[str, ...]:
        """Ids of all jobs of a kind, oldest first."""
        return self._registry.ids(kind)

    def close(self) -> None:
        """What runs is cancelled, what waits is left for the next start.  Idempotent."""
        with self._lock:
            self._closed.set()
        self._registry.say_ended()
        self._registry.cancel([job for job in self._registry.all() if job.has_begun])
        self._thread.shutdown(wait=True, cancel_futures=True)
        self.computer.close()
