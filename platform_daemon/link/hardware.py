"""What the other processes may ask of the one that owns the hardware.

Requests and answers are schemas; samples never cross: the handover is the shot's file on disk.
"""

from __future__ import annotations

from typing import Protocol

from platform_daemon.schemas import (
    AcquisitionRequest,
    AcquisitionSummary,
    ActivationRequest,
    AnyProcedureRequest,
    AnyQueuedRequest,
    CalibrationRequest,
    CalibrationsInUse,
    DeviceListing,
    FaultCleared,
    FaultReset,
    FaultUnlock,
    LedgerPage,
    LedgerRow,
    MountedResonator,
    MountRequest,
    PlatformStatus,
    ProcedureSummary,
    QueueOrder,
    Schedule,
    ScheduleRequest,
    SelfTestRequest,
    ShotHarmonics,
    ShotPage,
    StopReport,
)

from .jobs import ShownJob


class JobHolder(Protocol):
    """Holds jobs of some kinds."""

    def job_ids(self, kind: str) -> tuple[str, ...]:
        """Ids of all jobs of a kind, oldest first."""

    def jobs(self, kind: str, identifiers: tuple[str, ...]) -> tuple[ShownJob, ...]:
        """Those of these ids.  Raises UnknownId."""

    def job(self, kind: str, identifier: str) -> ShownJob:
        """The job of that id.  Raises UnknownId."""

    def cancel(self, kind: str, identifier: str) -> ShownJob:
        """Ask it to stop, and the job after that.  Raises UnknownId."""


class Hardware(JobHolder, Protocol):
    """The owner of the hardware.  Every method may raise HardwareAway, and DeviceError while devices are not open."""

    def has_happened(self) -> None:
        """Somebody is about to hear of something new: what was answered a moment ago does for nobody any more."""

    def status(self) -> PlatformStatus:
        """Devices as last read back, and the job that runs."""

    def devices(self) -> DeviceListing:
        """Each device as last read back."""

    def warm(self) -> dict[str, bool]:
        """By part: has it done what takes long the first time?"""

    def last_harmonics(self) -> ShotHarmonics | None:
        """Of the last excited shot; None: there was none."""

    def outputs_off(self) -> StopReport:
        """Everything off, now; all that moves something or waits to is cancelled.  Raises DeviceError."""

    def reset_fault(self) -> FaultReset:
        """Clear the amplifier's latched fault.  Raises DeviceError."""

    def unlock(self, request: FaultUnlock) -> FaultCleared:
        """Clear the fault of a dead owner.  Raises InputError without a name, DeviceError."""

    def acquire(self, request: AcquisitionRequest) -> ShownJob:
        """Queue a series.  Raises InputError, StorageUnusable; nothing moves then."""

    def shots(self, identifier: str, after: int, limit: int) -> ShotPage:
        """Shots of an acquisition of this run of the process with numbers above `after`.  Raises UnknownId."""

    def dry_run(self, request: AcquisitionRequest) -> AcquisitionSummary:
        """The same checks; nothing moves.  Raises InputError, StorageUnusable."""

    def conduct(self, request: AnyProcedureRequest) -> ShownJob:
        """Queue a procedure.  Raises InputError, StorageUnusable; nothing moves then."""

    def dry_run_procedure(self, request: AnyProcedureRequest) -> ProcedureSummary:
        """The same checks; nothing moves.  Raises InputError, StorageUnusable."""

    def pause(self, kind: str, identifier: str) -> ShownJob:
        """Rest at the next safe point.  Raises UnknownId, DeviceStateError for a job that has ended."""

    def resume(self, kind: str, identifier: str) -> ShownJob:
        """Go on after a pause, or with the missing shots of a series that was cut off.

        Raises UnknownId, DeviceStateError for another job that has ended, InputError, StorageUnusable.
        """

    def edit(self, kind: str, identifier: str, request: AnyQueuedRequest) -> ShownJob:
        """Another request for a job that has not begun.

        Raises UnknownId, DeviceStateError once it has, InputError, StorageUnusable, StorageError.
        """

    def order(self, asked: QueueOrder) -> PlatformStatus:
        """Jobs that wait, in another order.  Raises InputError, DeviceStateError: one of them waits not."""

    def calibrate(self, request: CalibrationRequest) -> ShownJob:
        """Queue a calibration.  Raises InputError, StorageUnusable; nothing moves then."""

    def self_test(self, request: SelfTestRequest) -> ShownJob:
        """Queue a self-test.  Raises InputError; nothing moves then."""

    def answer(self, kind: str, identifier: str) -> ShownJob:
        """What the job has asked of the operator is done.  Raises UnknownId, DeviceStateError if it asks nothing."""

    def activate(self, request: ActivationRequest) -> CalibrationsInUse:
        """Use another calibration from the next series on.  Raises InputError, DeviceStateError."""

    def mounted(self) -> MountedResonator:
        """What is in the clamping unit, as far as anybody has said."""

    def say_mounted(self, request: MountRequest) -> MountedResonator:
        """It was put there.  Raises InputError: no resonator has that name; StorageError."""

    def add_schedule(self, request: ScheduleRequest) -> Schedule:
        """Keep a schedule.  Raises InputError: never due, shorter than its work, work not possible; StorageError."""

    def list_schedules(self) -> tuple[Schedule, ...]:
        """All that were not removed.  Raises StorageError."""

    def get_schedule(self, identifier: str) -> Schedule:
        """One of them.  Raises UnknownSchedule, StorageError."""

    def ledger(self, identifier: str, after: int, limit: int) -> LedgerPage:
        """Rows of its ledger with numbers above `after`.  Raises UnknownSchedule, StorageError."""

    def pause_schedule(self, identifier: str) -> Schedule:
        """Start nothing more.  Raises UnknownSchedule, StorageError."""

    def resume_schedule(self, identifier: str) -> Schedule:
        """Start again what is due from now on.  Raises UnknownSchedule, StorageError."""

    def run_schedule(self, identifier: str) -> LedgerRow:
        """Start it once, now.  Raises UnknownSchedule, DeviceStateError, StorageError."""

    def remove_schedule(self, identifier: str) -> Schedule:
        """It starts nothing any more.  Raises UnknownSchedule, StorageError."""

    def preview_schedule(self, request: ScheduleRequest, count: int) -> tuple[str, ...]:
        """The first instants.  Raises InputError, StorageError."""
