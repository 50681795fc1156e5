"""Jobs of all kinds in one list."""

from __future__ import annotations

from pydantic import ConfigDict

from .base import Absent, ClockKind, ListPage, Schema, example
from .jobs import JobState, Progress


class JobSummary(Schema):
    """A job in short."""

    id: str
    """Id of the job."""
    kind: str
    """Kind of the job."""
    procedure: str | None
    """Kind of the procedure; null: it is none."""
    resonator: str | None
    """Resonator that it measures; null: none."""
    path: str
    """Path of the job itself."""
    state: JobState
    """Where it is in its life."""
    progress: Progress
    """How far it is."""
    created: str | None
    """When it was requested, ISO 8601."""
    finished: str | None
    """When it ended, ISO 8601; null: not yet."""
    clock: Absent[ClockKind] = None
    """Clock that the times of its shots and of its recording go by; `created` and `finished` are always by that of this
    computer.  Missing: it uses no platform, or an earlier version wrote its record."""
    within: str | None
    """Id of the procedure that it is a step of; null: it stands for itself."""
    recording: str | None
    """Id of its recording; null: there is none, or none yet."""
    priority: int
    """Of several that wait the highest begins first."""
    paused: bool
    """It is paused, or will be after the shot that runs."""
    question: str | None
    """What the operator has to do before it goes on; null: nothing."""
    error: str | None
    """Why it failed; null: it did not."""


class JobListing(ListPage[JobSummary]):
    """Jobs in short, newest first."""

    model_config = ConfigDict(json_schema_extra=example("job_listing"))
