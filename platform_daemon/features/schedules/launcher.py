"""What the schedules need of the queue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

from .schema import AnyWorkRequest


@dataclass(frozen=True)
class JobOutcome:
    """What became of a job.

    state: unknown: no such job was ever made; resting: it was paused before it began; reason: why it failed; recording:
    id of what it recorded.
    """

    state: Literal["running", "resting", "done", "failed", "cancelled", "unknown"]
    reason: str | None = None
    recording: str | None = None


class Launcher(Protocol):
    """Makes jobs, and knows what became of them."""

    def planned_s(self, work: AnyWorkRequest) -> float | None:
        """How long the work takes at least by its plan, in s; None: unknown.  Raises InputError: not possible."""

    def busy(self) -> bool:
        """Whether a job has the hardware or waits for it; one that was paused before it began does not count."""

    def missing(self, work: AnyWorkRequest, *, surely: bool) -> str | None:
        """What the work waits for; None: nothing.

        A person has to mount its resonator (surely: also if it is not known which one is mounted), or the recordings
        are being indexed.
        """

    def new_id(self, work: AnyWorkRequest) -> str:
        """A new id for its job."""

    def stops(self) -> int:
        """How often everything was stopped.  Raises DeviceError while the devices are not open."""

    def launch(self, work: AnyWorkRequest, job: str, stops: int) -> None:
        """Queue the work under the id `job`.  The job is cancelled if there were more stops than `stops` by now.

        Raises PlatformError, and then nothing was queued.
        """

    def outcome(self, job: str) -> JobOutcome:
        """What became of the job.  Raises DeviceError while the devices are not open."""
