"""Who starts what is due."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from platform_daemon.schemas import AnyWorkRequest


@dataclass(frozen=True)
class JobOutcome:
    """Where a job is; reason: why it failed; recording: id of what it recorded."""

    state: Literal["running", "done", "failed", "cancelled"]
    reason: str | None = None
    recording: str | None = None


class Launcher(Protocol):
    """The owner of the queue."""

    def planned_s(self, work: AnyWorkRequest) -> float | None:
        """How long it takes by its plan, s; None: nobody knows.  Raises InputError: it could not be done."""

    def busy(self) -> bool:
        """Does something run or wait?"""

    def launch(self, work: AnyWorkRequest) -> str:
        """Queue it; the id of its job.  Raises PlatformError: nothing was queued."""

    def outcome(self, job: str) -> JobOutcome:
        """Where the job is.  Raises DeviceError while the owner cannot say."""
