"""A job, as the process that owns the hardware tells the others of it."""

from __future__ import annotations

from .base import Schema
from .job_records import StoredJob
from .jobs import Progress
from .link import LinkError


class JobSnapshot(Schema):
    """A job as it is at one moment."""

    record: StoredJob
    """What is kept of it on disk."""
    progress: Progress
    """How far it is."""
    error: LinkError | None
    """Why it failed; null: it did not."""
    question: str | None
    """What the operator has to do before it goes on; null: nothing."""
    paused: bool
    """It rests, or will do so at the next safe point."""
