"""The application service: what CLI, REST, schedules and procedures may ask of the owner of the hardware.

Requests and answers are schemas; samples never cross: the handover is the shot's file on disk.  Each method says how it
may be repeated: a *query* is answered from a cache of 50 ms, a *command* invalidates that cache before and after, a
*check* neither uses it nor invalidates it.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Any, Protocol, TypeVar

from platform_daemon.core.schemas.acquisitions import ShotPage
from platform_daemon.core.schemas.base import Schema
from platform_daemon.core.schemas.calibrations import CalibrationsInUse
from platform_daemon.core.schemas.harmonics import ShotHarmonics
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.platform import DeviceListing, FaultReset, PlatformStatus
from platform_daemon.core.schemas.requests import ActivationRequest
from platform_daemon.core.schemas.stop import StopReport
from platform_daemon.core.schemas.unattended import (
    FaultCleared,
    FaultUnlock,
    MountedResonator,
    MountRequest,
    QueueOrder,
)

from .job_view import JobView

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])


class Repeat(Enum):
    """How often a method may be called for one answer."""

    QUERY = "answered from a cache of 50 ms"
    COMMAND = "invalidates the cache"
    CHECK = "neither"


def query(function: FunctionT) -> FunctionT:
    """Mark a method of a service as a query."""
    function.repeat = Repeat.QUERY  # type: ignore[attr-defined]
    return function


def command(function: FunctionT) -> FunctionT:
    """Mark a method of a service as a command."""
    function.repeat = Repeat.COMMAND  # type: ignore[attr-defined]
    return function


class JobService(Protocol):
    """Jobs of some kinds.  `kind` is that of a feature's job; every method raises InputError for another one."""

    @command
    def submit(self, kind: str, request: Any) -> JobView:
        """Queue a job.  Raises InputError, StorageUnusable, InterlockError; nothing moves then."""

    @command
    def submit_once(self, kind: str, request: Any, key: str) -> JobView:
        """Queue a job, unless one was queued with that idempotency key: then that job, as it is now.

        Raises as `submit`, and IdempotencyKeyReused if the first request with the key was another one.
        """

    def dry_run(self, kind: str, request: Any) -> Schema:
        """The same checks; nothing moves.  Raises as `submit`, and InputError for a kind that has no dry run."""

    @query
    def job_ids(self, kind: str) -> tuple[str, ...]:
        """Ids of all jobs of a kind, oldest first.  Raises InputError for a kind that no feature has."""

    @query
    def job_ids_in(self, kind: str, states: tuple[JobState, ...]) -> tuple[str, ...]:
        """As `job_ids`, of the jobs in one of these states; no record is read for it.  Raises StorageError, too."""

    @query
    def jobs(self, kind: str, identifiers: tuple[str, ...]) -> tuple[JobView, ...]:
        """The jobs of these ids.  Raises UnknownId."""

    @query
    def job(self, kind: str, identifier: str) -> JobView:
        """The job of that id.  Raises UnknownId."""

    @command
    def cancel(self, kind: str, identifier: str) -> JobView:
        """Request that it stops; the job after that.  Raises UnknownId."""


class PlatformService(JobService, Protocol):
    """The owner of the hardware.  Every method may raise HardwareAway, and DeviceError while devices are not open."""

    @query
    def status(self) -> PlatformStatus:
        """Devices as last read back, and the job that runs."""

    @query
    def devices(self) -> DeviceListing:
        """Each device as last read back."""

    @query
    def warm(self) -> dict[str, bool]:
        """For each part: what takes long the first time has been done."""

    @query
    def last_harmonics(self) -> ShotHarmonics | None:
        """Of the last excited shot; None: there was none."""

    @command
    def outputs_off(self) -> StopReport:
        """Everything off, now; all that moves something or waits to is cancelled.  Raises DeviceError."""

    @command
    def reset_fault(self) -> FaultReset:
        """Clear the amplifier's latched fault.  Raises DeviceError."""

    @command
    def unlock(self, request: FaultUnlock) -> FaultCleared:
        """Clear the fault of a dead owner.  Raises InputError without a name, DeviceError."""

    @query
    def shots(self, kind: str, identifier: str, after: int, limit: int) -> ShotPage:
        """Shots of a series of this run of the process with numbers above `after`.  Raises UnknownId."""

    @command
    def pause(self, kind: str, identifier: str) -> JobView:
        """Pause at the next safe point.  Raises UnknownId, DeviceStateError for a job that has ended."""

    @command
    def resume(self, kind: str, identifier: str) -> JobView:
        """Go on after a pause, or with the missing shots of a series that was cut off.

        Raises UnknownId, DeviceStateError for another job that has ended, InputError, StorageUnusable.
        """

    @command
    def edit(self, kind: str, identifier: str, request: Any) -> JobView:
        """Another request for a job that has not begun.

        Raises UnknownId, DeviceStateError once it has, InputError, StorageUnusable, StorageError.
        """

    @command
    def order(self, request: QueueOrder) -> PlatformStatus:
        """Waiting jobs in another order.  Raises InputError, DeviceStateError: one of them does not wait."""

    @command
    def answer(self, kind: str, identifier: str) -> JobView:
        """Report that the operator has done the step that the job waits for.  Raises UnknownId, DeviceStateError."""

    @command
    def activate(self, request: ActivationRequest) -> CalibrationsInUse:
        """Use another calibration from the next series on.  Raises InputError, DeviceStateError."""

    @query
    def mounted(self) -> MountedResonator:
        """The resonator in the clamping unit, as far as it is known."""

    @command
    def set_mounted(self, request: MountRequest) -> MountedResonator:
        """This one is there now.  Raises InputError: no resonator has that name; StorageError."""
