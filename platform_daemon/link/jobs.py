"""A job as others see it: what was asked, how far it is, what came out, at one moment."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from drivers.errors import DeviceStateError, PlatformError
from platform_daemon.engine import AnyJob, record_of
from platform_daemon.schemas import AnyJobRecord, JobSnapshot, JobState, Progress, StoredJob

from .errors import error_from_wire, error_on_wire


@dataclass(frozen=True)
class ShownJob:
    """A job at one moment: `record` as kept on disk, how far it is, why it failed, what it waits for.

    question: what the operator has to do before it goes on, None: nothing; paused: it rests, or will at the next safe
    point.
    """

    record: AnyJobRecord
    progress: Progress
    error: PlatformError | None = None
    question: str | None = None
    paused: bool = False

    @classmethod
    def of(cls, job: AnyJob) -> ShownJob:
        """A job of this process, as it is now."""
        paused = job.pause_requested.is_set() and not job.state.final
        error = None if job.error is None else error_from_wire(error_on_wire(job.error))
        return cls(record_of(job).root, job.progress(), error, job.question, paused)

    @classmethod
    def from_snapshot(cls, told: JobSnapshot) -> ShownJob:
        """A job of another process."""
        error = None if told.error is None else error_from_wire(told.error)
        return cls(told.record.root, told.progress, error, told.question, told.paused)

    def snapshot(self) -> JobSnapshot:
        """As it goes over the socket."""
        error = None if self.error is None else error_on_wire(self.error)
        return JobSnapshot(
            record=StoredJob(self.record),
            progress=self.progress,
            error=error,
            question=self.question,
            paused=self.paused,
        )

    @property
    def identifier(self) -> str:
        """Id of the job."""
        return self.record.identifier

    @property
    def kind(self) -> str:
        """Kind of the job."""
        return self.record.kind

    @property
    def state(self) -> JobState:
        """Where it is in its life."""
        return self.record.state

    @property
    def request(self) -> Any:
        """What was asked for."""
        return self.record.request

    @property
    def result(self) -> Any:
        """What came out so far."""
        return self.record.result


class _Keeper(Protocol):
    def job(self, kind: str, identifier: str) -> AnyJob: ...
    def job_ids(self, kind: str) -> tuple[str, ...]: ...


class LocalJobs:
    """Jobs of this process, as they are shown to others; see JobHolder."""

    def __init__(self, keeper: _Keeper) -> None:
        self._keeper = keeper

    def job_ids(self, kind: str) -> tuple[str, ...]:
        """See JobHolder."""
        return self._keeper.job_ids(kind)

    def jobs(self, kind: str, identifiers: tuple[str, ...]) -> tuple[ShownJob, ...]:
        """See JobHolder."""
        return tuple(ShownJob.of(self._keeper.job(kind, each)) for each in identifiers)

    def job(self, kind: str, identifier: str) -> ShownJob:
        """See JobHolder."""
        return ShownJob.of(self._keeper.job(kind, identifier))

    def cancel(self, kind: str, identifier: str) -> ShownJob:
        """See JobHolder."""
        return self._told(kind, identifier, lambda job: job.request_cancel())

    def _told(self, kind: str, identifier: str, tell: Callable[[AnyJob], None]) -> ShownJob:
        tell(self._keeper.job(kind, identifier))
        return ShownJob.of(self._keeper.job(kind, identifier))  # another one may have come in its place


def alive(job: AnyJob) -> AnyJob:
    """Raises DeviceStateError for one that has ended."""
    if job.state.final:
        remedy = "ask for the steps that are missing as a new procedure"
        raise DeviceStateError(f"the {job.kind} has ended", where=job.identifier, why=str(job.state), remedy=remedy)
    return job


def rest(job: AnyJob, *, pause: bool) -> None:
    """Ask it to rest, or to go on; of one that waits it is kept, so that it does not begin after a restart either.

    Raises DeviceStateError for one that has ended.
    """
    if not job.ask_pause(pause=pause):
        alive(job)


def waiting(job: AnyJob) -> AnyJob:
    """Raises DeviceStateError for one that asks nothing."""
    if job.question is None:
        raise DeviceStateError(
            f"the {job.kind} does not wait for anything", where=job.identifier, remedy="look at `state`"
        )
    return job
