"""Jobs on stored recordings, in one thread of the web process, one after the other; workers compute."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import structlog

from drivers.errors import InputError, PlatformError
from platform_daemon.core.jobs.events import EventSink, null_sink
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.job_registry import JobRegistry
from platform_daemon.core.jobs.jobs import AnyJob, Job, RequestT, ResultT, Work
from platform_daemon.core.jobs.submit_options import ShuttingDown
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.core.recordings.data_folder import DataFolder
from platform_daemon.core.registry import feature_of, kinds
from platform_daemon.core.schemas.base import Schema
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.state.errors import StorageError

from .bench import AnalysisBench
from .job_view import JobView
from .submit_once import SubmitOnce

log = structlog.get_logger()


class AnalysisJobs:
    """See JobService, for the kinds that do not need the hardware.

    executor: runs what they compute, in a process that is killed to cancel it; folders: of the daemon's data.
    """

    def __init__(
        self,
        executor: TaskExecutor,
        folders: DataFolder,
        journal: JobRecords | None = None,
        tell: EventSink = null_sink,
    ) -> None:
        self.executor = executor
        self._bench = AnalysisBench(executor=executor, folders=folders)
        self._registry = JobRegistry(journal or JobRecords(None), kinds(on_hardware=False), tell)
        self._once = SubmitOnce()
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="analyses")
        self._lock, self._closed, self._refused = threading.Lock(), self._registry.ends, ""

    def submit(self, kind: str, request: Any, identifier: str | None = None) -> JobView:
        """See JobService; identifier: id of the job, None: a new one.  Raises InputError, ShuttingDown."""
        work = self._plan(kind, request)
        with self._lock:
            if self._closed.is_set():
                raise ShuttingDown("the daemon is shutting down", remedy="start it again, then submit the job again")
            return JobView.of(self._queued(work, identifier=identifier))

    def submit_once(self, kind: str, request: Any, key: str) -> JobView:
        """See JobService."""
        return self._once.job(self, kind, request, key, lambda identifier: self.submit(kind, request, identifier))

    def dry_run(self, kind: str, request: Any) -> Schema:
        """See JobService."""
        raise InputError(f"a {kind} has no dry run", where="kind", remedy="submit it: nothing moves")

    def _plan(self, kind: str, request: Any) -> Work[Any, Any]:
        feature = feature_of(kind)
        if feature.kind.needs_hardware:
            raise InputError(f"a {kind} needs the platform", where="kind", remedy="ask the process that owns it")
        work: Work[Any, Any] = feature.load(feature.kind.plan)(self._bench, request)
        return work

    def take_up(self) -> None:
        """Queue the jobs that wait and that this process has not queued: of an earlier run, or written by another one.

        One that cannot be planned any more is failed with the reason."""
        with self._lock:  # one that is requested now is on the disk before it is known
            found = self._registry.found_waiting()
        for job in found:
            try:
                work = self._plan(job.kind, job.request)
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

    def _queued(
        self, work: Work[RequestT, ResultT], again: AnyJob | None = None, identifier: str | None = None
    ) -> Job[RequestT, ResultT]:
        job = Job.of(work, again=again, identifier=identifier)
        self._registry.add(job)
        self._thread.submit(job.run, work)
        return job

    def job_ids(self, kind: str) -> tuple[str, ...]:
        """See JobService."""
        return self._registry.ids(kind)

    def job_ids_in(self, kind: str, states: tuple[JobState, ...]) -> tuple[str, ...]:
        """See JobService."""
        return self._registry.ids_in(kind, states)

    def jobs(self, kind: str, identifiers: tuple[str, ...]) -> tuple[JobView, ...]:
        """See JobService."""
        return tuple(self.job(kind, each) for each in identifiers)

    def job(self, kind: str, identifier: str) -> JobView:
        """See JobService."""
        return JobView.of(self._registry.job(kind, identifier))

    def cancel(self, kind: str, identifier: str) -> JobView:
        """See JobService."""
        self._registry.job(kind, identifier).request_cancel()
        return self.job(kind, identifier)

    def close(self) -> None:
        """What runs is cancelled, what waits is left for the next start.  Idempotent."""
        with self._lock:
            self._closed.set()
        self._registry.say_ended()
        self._registry.cancel([job for job in self._registry.all() if job.has_begun])
        self._thread.shutdown(wait=True, cancel_futures=True)
        self.executor.close()
