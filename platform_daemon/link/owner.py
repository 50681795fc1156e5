"""The contract on an engine in this process."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence

from drivers.errors import DeviceStateError, PlatformError
from platform_daemon.engine import (
    AnyJob,
    Asked,
    Engine,
    check_model,
    edit_waiting,
    plan_calibration,
    put_in_order,
    queue_self_test,
    resume_series,
)
from platform_daemon.schedules import ScheduleKeeper
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
    MountedResonator,
    MountRequest,
    PlatformStatus,
    ProcedureSummary,
    QueueOrder,
    SelfTestRequest,
    ShotHarmonics,
    ShotPage,
    StopReport,
)
from platform_daemon.store import Mark, check_room
from platform_daemon.workers import WorkerLimits

from .jobs import LocalJobs, ShownJob, rest, waiting
from .mounted import Mounted
from .owned_schedules import OwnedSchedules
from .plans import Folders, Plans
from .queue import take_up_queue
from .stopping import STOPPED


class OwnedHardware(LocalJobs, OwnedSchedules):
    """See Hardware.  schedules: None: there are none; mark: of a stop that found nobody; limits: of planning."""

    def __init__(
        self,
        engine: Engine,
        folders: Folders,
        schedules: ScheduleKeeper | None = None,
        mark: Mark | None = None,
        limits: WorkerLimits = WorkerLimits(),  # noqa: B008 frozen
    ) -> None:
        LocalJobs.__init__(self, engine)
        OwnedSchedules.__init__(self, schedules)
        self._engine, self._folders = engine, folders
        self._mark, self._taking_up = mark, threading.Lock()
        self._plans = Plans(engine, folders, limits)
        self._mounted = Mounted(folders.mounted, changes_itself=engine.platform.changes_resonators)

    def has_happened(self) -> None:
        """See Hardware: nothing is kept here."""

    def status(self) -> PlatformStatus:
        """See Hardware."""
        return self._engine.status()

    def busy(self) -> bool:
        """Does something run, or wait that will begin by itself?"""
        engine = self._engine
        busy = engine.status().running is not None or engine.conducts or engine.queue.awaits
        return busy or self._taking_up.locked()

    def devices(self) -> DeviceListing:
        """See Hardware."""
        return self._engine.devices()

    def warm(self) -> dict[str, bool]:
        """See Hardware."""
        return self._engine.warm

    def last_harmonics(self) -> ShotHarmonics | None:
        """See Hardware."""
        return self._engine.live.latest

    def outputs_off(self) -> StopReport:
        """See Hardware.  Schedules start nothing more until somebody resumes them."""
        schedules = self._schedules
        if schedules is not None:
            schedules.rest(STOPPED)  # first: what they start from now on is not asked for before the stop
        unproved = None
        try:
            self._engine.outputs_off(left=True)
        except PlatformError as refused:  # all is cancelled nevertheless
            unproved = refused
        if self._mark is not None:
            self._mark.forget()
        error = None if schedules is None else schedules.pause_all(STOPPED)
        if unproved is not None:
            raise unproved
        later = "" if error is None else f"; schedules rest, but that is not in their ledger yet: {error}"
        if self._engine.unsaved:
            later += f"; of {self._engine.unsaved} it is not on the disk, which refuses"
        return StopReport(status=f"outputs are off, acquisitions are cancelled{later}")

    @property
    def stops(self) -> int:
        """How often everything was stopped."""
        return self._engine.stops

    @property
    def _asked_now(self) -> Asked:
        return Asked(stops=self.stops)

    def reset_fault(self) -> FaultReset:
        """See Hardware."""
        return self._engine.reset_fault()

    def unlock(self, request: FaultUnlock) -> FaultCleared:
        """See Hardware."""
        fault = self._engine.unlock(request.by, request.reason)
        if fault is not None:  # what waited when the daemon was started
            self.take_up_queue()
        return FaultCleared(fault=fault, by=request.by)

    def acquire(self, request: AcquisitionRequest, asked: Asked | None = None) -> ShownJob:
        """See Hardware.  asked: None, a new one and now."""
        asked = asked or self._asked_now
        plan = self._plans.series(request)
        self._mounted.say(request.resonator, None)
        folder = self._folders.recordings
        return ShownJob.of(self._engine.acquire(plan, None, folder, asked=asked))

    def shots(self, identifier: str, after: int, limit: int) -> ShotPage:
        """See Hardware."""
        return self._engine.job("acquisition", identifier).shots.page(after, limit)

    def dry_run(self, request: AcquisitionRequest) -> AcquisitionSummary:
        """See Hardware."""
        return self._plans.series(request).summary()

    def conduct(self, request: AnyProcedureRequest, asked: Asked | None = None) -> ShownJob:
        """See Hardware; asked: as for `acquire`."""
        asked = asked or self._asked_now
        work = self._plans.procedure(request)
        self._mounted.say(request.acquisition.resonator, None)
        return ShownJob.of(self._engine.submit(work, asked=asked))

    def dry_run_procedure(self, request: AnyProcedureRequest) -> ProcedureSummary:
        """See Hardware."""
        return self._plans.procedure(request).summary()

    def pause(self, kind: str, identifier: str) -> ShownJob:
        """See Hardware."""
        return self._told(kind, identifier, lambda job: rest(job, pause=True))

    def resume(self, kind: str, identifier: str) -> ShownJob:
        """See Hardware."""
        job = self._engine.job(kind, identifier)
        if job.state.final and job.kind == "acquisition":
            return ShownJob.of(resume_series(self._engine, job, self._folders.recordings))
        return self._told(kind, identifier, lambda job: rest(job, pause=False))

    def edit(self, kind: str, identifier: str, request: AnyQueuedRequest) -> ShownJob:
        """See Hardware."""
        job = edit_waiting(self._engine, self._engine.job(kind, identifier), lambda: self._plans.work(request))
        if not isinstance(request, CalibrationRequest | SelfTestRequest):
            series = request if isinstance(request, AcquisitionRequest) else request.acquisition
            self._mounted.say(series.resonator, None)
        return ShownJob.of(job)

    def order(self, asked: QueueOrder) -> PlatformStatus:
        """See Hardware."""
        put_in_order(self._engine, asked.order, asked.priority)
        return self.status()

    def calibrate(self, request: CalibrationRequest, asked: Asked | None = None) -> ShownJob:
        """See Hardware; asked: as for `acquire`."""
        asked, folder = asked or self._asked_now, self._folders.calibrations
        check_room(folder, 0)  # a file of some kB: what it costs is the shots before it
        return ShownJob.of(self._engine.calibrate(request, folder, asked))

    def calibration_takes_s(self, request: CalibrationRequest) -> float:
        """How long its shots take at least, s.  Nothing moves.  Raises InputError: it cannot be made."""
        return sum(plan_calibration(self._engine, request, self._folders.calibrations).shots_s)

    def check_model(self, label: str | None, terms: Sequence[str] = ()) -> None:
        """Is there such a model, None: whatever a recording says, and are there such terms?  Raises InputError."""
        check_model(self._engine, label, terms)

    def self_test(self, request: SelfTestRequest, asked: Asked | None = None) -> ShownJob:
        """See Hardware; asked: as for `acquire`."""
        asked = asked or self._asked_now
        return ShownJob.of(queue_self_test(self._engine, request, asked))

    def answer(self, kind: str, identifier: str) -> ShownJob:
        """See Hardware."""
        return self._told(kind, identifier, lambda job: waiting(job).proceed.set())

    def activate(self, request: ActivationRequest) -> CalibrationsInUse:
        """See Hardware."""
        if not self._taking_up.acquire(blocking=False):
            what, remedy = "what waited when the daemon ended is being planned", "ask again in some seconds"
            raise DeviceStateError(what, where="calibration", remedy=remedy)
        try:
            return self._engine.activate(request, self._folders.calibrations)
        finally:
            self._taking_up.release()

    def take_up_queue(self, forget: Callable[[], str | None] = lambda: None) -> None:
        """See `take_up_queue`."""
        with self._taking_up:
            take_up_queue(self._engine, self, forget)

    def take_up(self, job: AnyJob) -> None:
        """Queue a job of an earlier run again, under its id.  Raises InputError, WaitsNoMore."""
        asked, folders = Asked(again=job, waits=True), self._folders
        match job.request:
            case AcquisitionRequest():
                resumed = job.result.recording is not None  # and had to wait
                plan = self._engine.plan(job.request)
                self._engine.acquire(plan, None, folders.recordings, goes_on=resumed, asked=asked)
            case CalibrationRequest():
                self._engine.calibrate(job.request, folders.calibrations, asked)
            case SelfTestRequest():
                queue_self_test(self._engine, job.request, asked)
            case _:
                self._engine.submit(self._plans.known_procedure(job.request), asked=asked)

    def mounted(self) -> MountedResonator:
        """See Hardware."""
        return self._mounted.now()

    def say_mounted(self, request: MountRequest) -> MountedResonator:
        """See Hardware."""
        self._plans.only_named(request.resonator)
        return self._mounted.say(request.resonator, request.by)

    def not_mounted(self, resonator: str, *, surely: bool) -> str | None:
        """See Mounted.missing."""
        return self._mounted.missing(resonator, surely=surely)
