"""Long work as jobs: the request, its progress and its result, as REST shows them and as the data folder keeps them."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Any, Generic, TypeVar

from pydantic import AliasChoices, Field

from .base import Absent, ClockKind, Schema
from .problems import ErrorRecord, Problem

RequestT = TypeVar("RequestT")
ResultT = TypeVar("ResultT")


class JobState(StrEnum):
    """queued -> running -> done | failed | cancelled; a queued job may be cancelled at once."""

    QUEUED = "queued"
    RUNNING = "running"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def final(self) -> bool:
        """True if nothing more will happen."""
        return self in (JobState.DONE, JobState.FAILED, JobState.CANCELLED)


class Progress(Schema):
    """How far a job is."""

    done: float
    """So much is done, in `unit`."""
    total: float
    """Of so much."""
    unit: str
    """shots, frames or share."""
    phase: str
    """What it does now."""
    fraction: float
    """Share done, 0 to 1."""
    time_left_s: float | None
    """Time left, s; null: not known yet."""


class Job(Schema, Generic[RequestT, ResultT]):
    """One piece of work."""

    id: str
    """Id of the job."""
    kind: str
    """Kind of the job."""
    state: JobState
    """Where it is in its life."""
    progress: Progress
    """How far it is."""
    created: str | None
    """When it was requested, ISO 8601."""
    started: str | None
    """When it began, ISO 8601; null: it waits, or was cancelled before."""
    finished: str | None
    """When it ended, ISO 8601; null: not yet."""
    request: RequestT
    """What was requested, with every default."""
    result: ResultT
    """What came out so far."""
    warnings: tuple[str, ...]
    """What may spoil the result."""
    error: Problem | None
    """Why it failed; null: it did not."""
    links: dict[str, str]
    """Path by what is there."""


class QueuedJob(Job[RequestT, ResultT], Generic[RequestT, ResultT]):
    """One that waits for the platform, if others are there before it."""

    priority: int
    """Of several that wait the highest begins first."""
    clock: Absent[ClockKind] = None
    """Clock that the times of its shots and of its recording go by; `created`, `started` and `finished` are always by
    that of this computer.  Missing: an earlier version wrote the record."""


class JobTimes(Schema):
    """When a job was requested, began and ended, ISO 8601; null: not yet."""

    created: str | None
    """When it was requested, ISO 8601."""
    started: str | None
    """Begun."""
    finished: str | None
    """Ended."""


class JobRecord(Schema, Generic[RequestT, ResultT]):
    """One job: a file in the data folder."""

    kind: str
    """Kind of the job."""
    # Records of earlier versions, which stay as they are in the data folder, have the key `identifier`.
    id: Annotated[str, Field(validation_alias=AliasChoices("id", "identifier"))]
    """Id of the job."""
    request: RequestT
    """What was requested, with every default."""
    total: int | float
    """How much is to be done, in `unit`."""
    unit: str
    """shots, frames or share."""
    state: JobState
    """Where it is in its life."""
    done: int | float
    """How much is done."""
    result: ResultT
    """What came out so far."""
    warnings: tuple[str, ...]
    """What may spoil the result."""
    times: JobTimes
    """When."""
    error: ErrorRecord | None
    """Why it failed; null: it did not."""
    within: Absent[str] = None
    """Id of the procedure that it is a step of; missing: it belongs to none."""
    place: Absent[int] = None
    """Place in the queue, from 0; missing: the queue was not put in order."""
    clock: Absent[ClockKind] = None
    """Clock of the platform that its shots go by; missing: it uses none, or an earlier version wrote the record."""
    arrival: Absent[int] = None
    """Number in the order in which jobs came to the queue; missing: it never did."""
    paused: Absent[bool] = None
    """It waits, and does not begin before it is resumed; missing: it does."""


AnyJobRecord = JobRecord[Any, Any]
"""The record of a job of any kind; `core.jobs.kinds.record_type` has the model of one kind."""
