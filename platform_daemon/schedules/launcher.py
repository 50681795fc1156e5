"""Who starts what is due."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from platform_daemon.schemas import AnyWorkRequest


@dataclass(frozen=True)
class JobOutcome:
    """Where a job is; unknown: it was never made; resting: paused before it began; reason: why it failed; recording: id
    of what it recorded."""

    state: Literal["running", "resting", "done", "failed", "cancelled", "unknown"]
    reason: str | None = None
    recording: str | None = None


class Launcher(Protocol):
    """The owner of the queue."""

    def planned_s(self, work: AnyWorkRequest) -> float | None:
        """How long it takes by its plan, s, at least; None: nobody knows.  Raises InputError: it could not be done."""

    def busy(self) -> bool:
        """Does something run on the platform, or wait for it?  What is paused before it has begun does neither."""

    def missing(self, work: AnyWorkRequest, *, surely: bool) -> str | None:
        """What it waits for: a person has to mount its resonator, the recordings are being indexed; None: nothing.
        surely: also if nobody has said which one is there."""

    def new_id(self, work: AnyWorkRequest) -> str:
        """An id for its job, which no other job has."""

    def stops(self) -> int:
        """How often everything was stopped.  Raises DeviceError while the owner cannot say."""

    def launch(self, work: AnyWorkRequest, job: str, stops: int) -> None:
        """Queue it under that id; cancelled if everything was stopped since it was so often, `stops`.

        Raises PlatformError: nothing was queued.
        """

    def outcome(self, job: str) -> JobOutcome:
        """Where the job is.  Raises DeviceError while the owner cannot say."""
