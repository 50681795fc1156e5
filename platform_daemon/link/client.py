"""The contract over the socket."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

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
    LinkCall,
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

from .address import NAME, connected
from .errors import away, error_from_wire
from .jobs import ShownJob
from .line import Line
from .recent import Ended, Recent
from .stopping import AWAY_S, PATIENCE_S, Stopper
from .wire import methods, plain

MOST_IDLE = 16  # connections


class RemoteHardware:
    """See Hardware.  For any number of threads: each call has a connection of its own."""

    def __init__(self, folder: Path, patience_s: float = PATIENCE_S, away_s: float = AWAY_S) -> None:
        self._path, self._patience_s = folder / NAME, patience_s
        self._stopper = Stopper(folder, away_s=away_s)
        self._idle: list[Line] = []
        self._lock = threading.Lock()
        self._recent, self._ended = Recent(), Ended()

    def job_ids(self, kind: str) -> tuple[str, ...]:
        """See JobHolder."""
        found: tuple[str, ...] = self._asked("job_ids", kind)
        return found

    def jobs(self, kind: str, identifiers: tuple[str, ...]) -> tuple[ShownJob, ...]:
        """See JobHolder."""
        known = {each: job for each in identifiers if (job := self._ended.get(kind, each)) is not None}
        missing = tuple(each for each in identifiers if each not in known)
        if missing:
            for job in self._asked("jobs", kind, missing):
                self._ended.keep(job)
                known[job.identifier] = job
        return tuple(known[each] for each in identifiers)

    def job(self, kind: str, identifier: str) -> ShownJob:
        """See JobHolder."""
        return self.jobs(kind, (identifier,))[0]

    def cancel(self, kind: str, identifier: str) -> ShownJob:
        """See JobHolder."""
        return self._job_told("cancel", kind, identifier)

    def has_happened(self) -> None:
        """See Hardware."""
        self._recent.forget()

    def status(self) -> PlatformStatus:
        """See Hardware."""
        found: PlatformStatus = self._asked("status")
        return found

    def devices(self) -> DeviceListing:
        """See Hardware."""
        found: DeviceListing = self._asked("devices")
        return found

    def warm(self) -> dict[str, bool]:
        """See Hardware."""
        found: dict[str, bool] = self._asked("warm")
        return found

    def last_harmonics(self) -> ShotHarmonics | None:
        """See Hardware."""
        found: ShotHarmonics | None = self._asked("last_harmonics")
        return found

    def outputs_off(self) -> StopReport:
        """See Hardware, and Stopper for one that does not answer."""
        try:
            return self._stopper.outputs_off()
        finally:
            self._recent.forget()

    def reset_fault(self) -> FaultReset:
        """See Hardware."""
        found: FaultReset = self._told("reset_fault")
        return found

    def unlock(self, request: FaultUnlock) -> FaultCleared:
        """See Hardware."""
        found: FaultCleared = self._told("unlock", request)
        return found

    def acquire(self, request: AcquisitionRequest) -> ShownJob:
        """See Hardware."""
        return self._job_told("acquire", request)

    def shots(self, identifier: str, after: int, limit: int) -> ShotPage:
        """See Hardware."""
        found: ShotPage = self._asked("shots", identifier, after, limit)
        return found

    def dry_run(self, request: AcquisitionRequest) -> AcquisitionSummary:
        """See Hardware."""
        found: AcquisitionSummary = self._call("dry_run", request)
        return found

    def conduct(self, request: AnyProcedureRequest) -> ShownJob:
        """See Hardware."""
        return self._job_told("conduct", request)

    def dry_run_procedure(self, request: AnyProcedureRequest) -> ProcedureSummary:
        """See Hardware."""
        found: ProcedureSummary = self._call("dry_run_procedure", request)
        return found

    def pause(self, kind: str, identifier: str) -> ShownJob:
        """See Hardware."""
        return self._job_told("pause", kind, identifier)

    def resume(self, kind: str, identifier: str) -> ShownJob:
        """See Hardware."""
        try:
            return self._job_told("resume", kind, identifier)
        finally:
            self._ended.forget(kind, identifier)

    def edit(self, kind: str, identifier: str, request: AnyQueuedRequest) -> ShownJob:
        """See Hardware."""
        return self._job_told("edit", kind, identifier, request)

    def order(self, asked: QueueOrder) -> PlatformStatus:
        """See Hardware."""
        found: PlatformStatus = self._told("order", asked)
        return found

    def calibrate(self, request: CalibrationRequest) -> ShownJob:
        """See Hardware."""
        return self._job_told("calibrate", request)

    def self_test(self, request: SelfTestRequest) -> ShownJob:
        """See Hardware."""
        return self._job_told("self_test", request)

    def answer(self, kind: str, identifier: str) -> ShownJob:
        """See Hardware."""
        return self._job_told("answer", kind, identifier)

    def activate(self, request: ActivationRequest) -> CalibrationsInUse:
        """See Hardware."""
        found: CalibrationsInUse = self._told("activate", request)
        return found

    def mounted(self) -> MountedResonator:
        """See Hardware."""
        found: MountedResonator = self._asked("mounted")
        return found

    def say_mounted(self, request: MountRequest) -> MountedResonator:
        """See Hardware."""
        found: MountedResonator = self._told("say_mounted", request)
        return found

    def add_schedule(self, request: ScheduleRequest) -> Schedule:
        """See Hardware."""
        found: Schedule = self._told("add_schedule", request)
        return found

    def list_schedules(self) -> tuple[Schedule, ...]:
        """See Hardware."""
        found: tuple[Schedule, ...] = self._asked("list_schedules")
        return found

    def get_schedule(self, identifier: str) -> Schedule:
        """See Hardware."""
        found: Schedule = self._asked("get_schedule", identifier)
        return found

    def ledger(self, identifier: str, after: int, limit: int) -> LedgerPage:
        """See Hardware."""
        found: LedgerPage = self._asked("ledger", identifier, after, limit)
        return found

    def pause_schedule(self, identifier: str) -> Schedule:
        """See Hardware."""
        found: Schedule = self._told("pause_schedule", identifier)
        return found

    def resume_schedule(self, identifier: str) -> Schedule:
        """See Hardware."""
        found: Schedule = self._told("resume_schedule", identifier)
        return found

    def run_schedule(self, identifier: str) -> LedgerRow:
        """See Hardware."""
        found: LedgerRow = self._told("run_schedule", identifier)
        return found

    def remove_schedule(self, identifier: str) -> Schedule:
        """See Hardware."""
        found: Schedule = self._told("remove_schedule", identifier)
        return found

    def preview_schedule(self, request: ScheduleRequest, count: int) -> tuple[str, ...]:
        """See Hardware."""
        found: tuple[str, ...] = self._call("preview_schedule", request, count)
        return found

    def close(self) -> None:
        """Connections that nobody uses are closed.  Idempotent."""
        with self._lock:
            for each in self._idle:
                each.close()
            self._idle.clear()

    def _job_told(self, method: str, *arguments: Any) -> ShownJob:
        job: ShownJob = self._told(method, *arguments)
        return job

    def _asked(self, method: str, *arguments: Any) -> Any:
        """A question, of which the answer of a moment ago will do."""
        return self._recent.answer((method, *arguments), lambda: self._call(method, *arguments))

    def _told(self, method: str, *arguments: Any) -> Any:
        """A command: what was known before it is forgotten before and after."""
        try:
            return self._call(method, *arguments)
        finally:
            self._recent.forget()

    def _call(self, method: str, *arguments: Any) -> Any:
        line = self._free_line()
        try:
            line.send(LinkCall(method=method, arguments=tuple(map(plain, arguments))))
            answer = line.answer()
        except (OSError, ValueError) as error:
            line.close()
            raise away(str(error) or type(error).__name__) from None
        except BaseException:
            line.close()
            raise
        if answer is None:
            line.close()
            raise away("it ended before it answered")
        self._give_back(line)
        if answer.error is not None:
            raise error_from_wire(answer.error)
        return methods()[method].read(answer.value)

    def _free_line(self) -> Line:
        """One that nobody uses and that is still open, else a new one.  Raises HardwareAway."""
        while True:
            with self._lock:
                line = self._idle.pop() if self._idle else None
            if line is None:
                break
            if not line.is_stale():
                return line
            line.close()
        try:
            return Line(connected(self._path, self._patience_s))
        except OSError as error:
            raise away(error.strerror or str(error)) from None

    def _give_back(self, line: Line) -> None:
        with self._lock:
            if len(self._idle) < MOST_IDLE:
                self._idle.append(line)
                return
        line.close()
