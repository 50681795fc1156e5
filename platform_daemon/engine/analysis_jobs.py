"""Work on what is stored, as jobs: fits, diagnoses, characterisations; in one thread, one after the other."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

from platform_daemon.workers import Computer

from .engine import ShuttingDown
from .happenings import Tell, quiet
from .job_records import JobRecords
from .job_registry import ANALYSES, JobRegistry
from .jobs import AnyJob, Job, RequestT, ResultT, Work


class AnalysisJobs:
    """Takes and keeps them.  computer: does what they compute; cancelled, its process is killed."""

    def __init__(self, computer: Computer, journal: JobRecords | None = None, tell: Tell = quiet) -> None:
        self.computer = computer
        self._registry = JobRegistry(journal or JobRecords(None), ANALYSES, tell)
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="analyses")
        self._lock, self._closed = threading.Lock(), False

    def analyse(self, work: Work[RequestT, ResultT]) -> Job[RequestT, ResultT]:
        """Queue it.  Raises ShuttingDown."""
        with self._lock:
            if self._closed:
                raise ShuttingDown("the daemon is shutting down", remedy="start it again, then ask anew")
            job = Job.of(work)
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
        """All cancelled.  Idempotent."""
        with self._lock:
            self._closed = True
        for job in self._registry.all():
            job.request_cancel()
        self._thread.shutdown(wait=True, cancel_futures=True)
        self.computer.close()
