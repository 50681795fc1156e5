"""A job as other processes and people see it: its record, its progress, and what it waits for, at one moment."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from drivers.errors import PlatformError
from platform_daemon.core.jobs.job_records import record_of
from platform_daemon.core.jobs.jobs import AnyJob
from platform_daemon.core.jobs.kinds import record_type
from platform_daemon.core.schemas.jobs import AnyJobRecord, JobState, Progress
from platform_daemon.core.schemas.rpc import RpcError

from .errors import error_from_wire, error_on_wire


@dataclass(frozen=True, kw_only=True)
class JobView:
    """A job at one moment.

    Attributes:
        record: as it is kept on disk.
        progress: how far it is.
        error: why it failed, None: it did not.
        question: what the operator has to do before it continues, None: nothing.
        paused: it is paused, or will be at the next safe point.
    """

    record: AnyJobRecord
    progress: Progress
    error: PlatformError | None = None
    question: str | None = None
    paused: bool = False

    @classmethod
    def of(cls, job: AnyJob) -> JobView:
        """A job of this process, as it is now."""
        return cls(
            record=record_of(job),
            progress=job.progress(),
            error=None if job.error is None else error_from_wire(error_on_wire(job.error)),
            question=job.question,
            paused=job.pause_requested.is_set() and not job.state.final,
        )

    def to_wire(self) -> dict[str, Any]:
        """Its parts, as the connection serialises them."""
        return {
            "record": self.record,
            "progress": self.progress,
            "error": None if self.error is None else error_on_wire(self.error),
            "question": self.question,
            "paused": self.paused,
        }

    @classmethod
    def from_wire(cls, sent: dict[str, Any]) -> JobView:
        """A job of another process, from the JSON of its parts.  Raises ValueError."""
        error = sent["error"]
        return cls(
            record=record_type(sent["record"]["kind"]).model_validate(sent["record"]),
            progress=Progress.model_validate(sent["progress"]),
            error=None if error is None else error_from_wire(RpcError.model_validate(error)),
            question=sent["question"],
            paused=sent["paused"],
        )

    @property
    def identifier(self) -> str:
        """Id of the job."""
        return self.record.id

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
        """Its request."""
        return self.record.request

    @property
    def result(self) -> Any:
        """Its result so far."""
        return self.record.result
