"""The engine: owner of the platform.  One hardware thread works through a queue; fits run beside it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import structlog

from drivers.errors import DeviceStateError, PlatformError
from drivers.platform import Platform
from platform_daemon.schemas import (
    AcquisitionRequest,
    ActivationRequest,
    CalibrationRequest,
    CalibrationsInUse,
    DeviceListing,
    FaultReset,
    JobState,
    PlatformStatus,
    SelfTestOptions,
)
from platform_daemon.workers import Computer, InThisProcess
from sequences.compiler import TransmitSide
from sequences.limits import SafetyLimits

from .asked import AS_NOW, Asked, ShuttingDown, WaitsNoMore
from .calibration_in_use import CalibrationFiles, CalibrationInUse
from .catalogue import Catalogue
from .happenings import Tell, quiet
from .hardware_queue import HardwareQueue
from .hardware_thread import HardwareThread
from .interlock import Interlock
from .job_records import JobRecords
from .job_registry import ON_HARDWARE, JobRegistry
from .jobs import AnyJob, Job, RequestT, ResultT, Work
from .live_estimate import LiveEstimate
from .planning import AcquisitionPlan, plan_acquisition
from .readback import Readback
from .warm_fits import WarmFits
from .work.calibration import calibration_work
from .work.calibration_bench import CalibrationJob
from .work.destination import OwnFile, SameFile
from .work.reset_fault import reset_amplifier
from .work.series import AcquisitionJob, SeriesBench, SeriesWork

if TYPE_CHECKING:
    from platform_daemon.analysis import Library

log = structlog.get_logger()


class Engine:
    """Runs acquisitions one after the other on one platform, and fits beside them.

    config_text is stored in every recording; models: adopted ones that on-line fits may use; self_test: what comes
    before each series and each transmit calibration; files: of calibrations, as the platform file names them;
    catalogue: what can be measured by name; online: computes on-line fits and plans; computing: what takes longer;
    tell: takes events.

    On-line fits have a thread.  Raises SequenceRejected if the self-test leaves the limits.
    """

    def __init__(
        self,
        platform: Platform,
        limits: SafetyLimits,
        config_text: str,
        journal: JobRecords | None = None,
        models: Library | None = None,
        self_test: SelfTestOptions | None = None,
        files: CalibrationFiles = CalibrationFiles(),  # noqa: B008 frozen
        catalogue: Catalogue = Catalogue(),  # noqa: B008 frozen
        online: Computer = InThisProcess(),  # noqa: B008 without state
        computing: Computer = InThisProcess(),  # noqa: B008 without state
        tell: Tell = quiet,
    ) -> None:
        self.platform = platform
        self.config_text = config_text
        self.live = LiveEstimate()
        self.catalogue = catalogue
        self.calibration_in_use = CalibrationInUse(platform, limits, self_test or SelfTestOptions(), files)
        self.models, self.online, self.computing = models, online, computing
        self._registry, self._tell = JobRegistry(journal or JobRecords(None), ON_HARDWARE, tell), tell
        self._online = ThreadPoolExecutor(max_workers=1, thread_name_prefix="online-fits")
        self._planning = threading.RLock()  # held while a job is made from what the platform is now
        self._closed = self._registry.ends
        self.stops = 0  # how often everything was stopped
        self._interlock, self._warm_fits = Interlock(platform, tell), WarmFits(self._online, online)
        self._readback = Readback(platform, tell)
        self._readback.refresh()
        self._hardware = HardwareThread(platform, self._interlock, self._readback, self._closed)

    @property
    def side(self) -> TransmitSide:
        """What sequences are planned for now."""
        return self.calibration_in_use.side

    def plan(self, request: AcquisitionRequest) -> AcquisitionPlan:
        """The checked plan of a request; nothing moves.  Raises InputError."""
        return plan_acquisition(request, self.side, self.models, self.catalogue, self.online)

    def acquire(
        self,
        plan: AcquisitionPlan,
        target: Path | None,
        folder: Path,
        *,
        overwrite: bool = False,
        goes_on: bool = False,
        asked: Asked = AS_NOW,
    ) -> AcquisitionJob:
        """Queue an acquisition.  It writes `target`, or `folder`/ID.h5; runs when those before it have ended.

        goes_on: in the recording that the job of an earlier run, `asked.again`, has left.  Raises DeviceStateError if
        the transmit side is no longer the planned one, or that one is gone on with already.
        """
        again = asked.again
        with self._planning:
            if goes_on and again is not None:
                known = self.job(again.kind, again.identifier)
                if known is not again and not known.state.final:
                    what, where = "its missing shots are queued", known.identifier
                    raise DeviceStateError(what, where=where, remedy="wait for them")
            if plan.side is not self.side:
                what = "the transmit calibration has changed since the plan was made"
                raise DeviceStateError(what, remedy="plan anew")
            same = SameFile(folder / f"{again.identifier}.h5") if again is not None and goes_on else None
            destination = same or OwnFile(target, folder, overwrite=overwrite)
            return self.submit(SeriesWork(self.series_bench, plan, destination), asked=asked)

    @property
    def queue(self) -> HardwareQueue:
        """What waits for the hardware."""
        return self._hardware.queue

    @property
    def series_bench(self) -> SeriesBench:
        """What a series is made with now."""
        self_test = self.calibration_in_use.self_test
        in_shot = partial(self._hardware.refresh, busy=True)
        fits = self._online, self.online
        return SeriesBench(self.platform, self.config_text, *fits, self.live, in_shot, self_test, self._tell)

    def calibrate(self, request: CalibrationRequest, folder: Path, asked: Asked = AS_NOW) -> CalibrationJob:
        """Queue a calibration, which writes a new version into `folder`.  Raises InputError; nothing moves then."""
        with self._planning:
            work = calibration_work(self.platform, request, self.side, folder, self.calibration_in_use.self_test)
            return self.submit(work, asked=asked)

    def submit(
        self, work: Work[RequestT, ResultT], within: AnyJob | None = None, asked: Asked = AS_NOW
    ) -> Job[RequestT, ResultT]:
        """Queue work on the hardware: it runs behind the interlock once those before it have ended.

        A procedure submits its steps itself; whatever stops that stops its step.  What everything was stopped after is
        cancelled.  Raises ShuttingDown, InterlockError while a fault stands, WaitsNoMore.
        """
        self._interlock.refuse()
        with self._planning:
            if self._closed.is_set():
                raise ShuttingDown("the daemon is shutting down", remedy="start it again, then ask anew")
            job = self._registered(work, within, asked)
            if asked.stops is not None and asked.stops != self.stops:  # looked at once a stop can reach it
                job.request_cancel()
            self._hardware.put(job, work)
            return job

    def _registered(self, work: Work[RequestT, ResultT], within: AnyJob | None, asked: Asked) -> Job[RequestT, ResultT]:
        if not asked.waits or asked.again is None:
            job = Job.of(work, within, asked.again, asked.identifier)
            self._registry.add(job, queued=True)
            return job
        with asked.again.held() as waits:  # what was told that one until now holds, and from now on is told this one
            if not waits:
                raise WaitsNoMore("it was cancelled", where=asked.again.identifier)
            job = Job.of(work, within, asked.again)
            self._registry.add(job, queued=True)
            asked.again.successor = job
            return job

    def activate(self, request: ActivationRequest, folder: Path) -> CalibrationsInUse:
        """Use another calibration, of `folder`, from the next series on; what is in use then.

        Raises InputError for a file that is none or not one of this platform, DeviceStateError while a series or a
        calibration runs or waits: each ends with what it began with.
        """
        with self._planning:
            if any(not job.state.final for job in self._registry.stoppable()):
                what, remedy = "a series, a calibration or a procedure", "wait until all have ended, or cancel them"
                raise DeviceStateError(f"{what} runs or waits", where="calibration", remedy=remedy)
            self.calibration_in_use.activate(request, folder)
            return self.calibration_in_use.in_use()

    def job(self, kind: str, identifier: str) -> AnyJob:
        """The job of that id.  Raises UnknownId."""
        return self._registry.job(kind, identifier)

    def job_ids(self, kind: str) -> tuple[str, ...]:
        """Ids of all jobs of a kind, oldest first."""
        return self._registry.ids(kind)

    def status(self) -> PlatformStatus:
        """Devices as last read back (a second ago while idle, in the RX window of a long shot), and the job."""
        jobs, in_use = self._registry, self.calibration_in_use.in_use()
        waiting = tuple(job.identifier for job in self.queue.jobs())
        return self._readback.status(in_use, self._interlock.stands, jobs.running, waiting)

    def devices(self) -> DeviceListing:
        """Each device as last read back: identity, state, the error if it did not answer, and its last error."""
        return DeviceListing(devices=self._readback.devices)

    @property
    def warm(self) -> dict[str, bool]:
        """By part: has it done what takes long the first time?  Jobs wait for the platform."""
        return {"platform": self._hardware.warm.is_set(), "estimator": self._warm_fits.done.is_set()}

    def warm_up_fits(self) -> None:
        """Have the estimator's kernels loaded, or compiled, there where on-line fits are made, before the first."""
        self._warm_fits.begin()

    def outputs_off(self, *, left: bool = False) -> None:
        """Everything off, now, from any thread; all that moves something or waits to is cancelled.  left: of an earlier
        run too, that nobody has queued again."""
        self.stops += 1  # before anything is looked for: what is queued from now on sees it
        self._all_off(partial(self._registry.stoppable, left=left))

    def _all_off(self, jobs: Callable[[], list[AnyJob]]) -> None:
        try:
            for job in jobs():
                job.cancel_requested.set()
        finally:
            try:
                self._interlock.prove_off()
            finally:
                self._registry.cancel(jobs())

    def reset_fault(self) -> FaultReset:
        """See `reset_amplifier`.  Raises also DeviceStateError while a job moves something."""
        with self._hardware.at_rest():
            return reset_amplifier(self.platform)

    def unlock(self, by: str, reason: str) -> str | None:
        """Prove the outputs off, then clear the fault of a dead owner in a person's name; what it was.

        Raises DeviceStateError while a job moves something, InputError without a name, DeviceError.
        """
        with self._hardware.at_rest():
            return self.platform.guard.reset(by, reason)

    def keep(self, job: AnyJob) -> None:
        """What was changed of one that waits, on disk.  Raises StorageError."""
        self._registry.keep(job)

    def left_waiting(self) -> list[AnyJob]:
        """Jobs of an earlier run that had not begun, oldest first."""
        return self._registry.left_waiting()

    @property
    def conducts(self) -> bool:
        """Does a procedure make its steps, and does not rest?"""
        return self._registry.conducts

    @property
    def unsaved(self) -> int:
        """Jobs that have ended, and the disk does not have it yet."""
        return self._registry.unsaved

    def end_left(self, job: AnyJob, state: JobState, error: PlatformError | None = None) -> bool:
        """See JobRegistry."""
        return self._registry.end_left(job, state, error)

    def close(self, *, keep_queue: bool = False) -> None:
        """Outputs off, jobs cancelled, threads ended, devices let go.  Idempotent.

        keep_queue: what has not begun stays as it is, for the next start.
        """
        if self._closed.is_set():
            return
        self._closed.set()  # no lock yet: none may hold up outputs off
        ends = self._registry.begun if keep_queue else self._registry.all
        try:
            self._registry.say_ended()
            self._all_off(ends)
        finally:
            with self._planning:  # work that was still taken is queued now
                self._hardware.put_end()
            self._registry.cancel(ends())
            try:
                self._hardware.join()
            finally:
                self.platform.close()
        self._hardware.join_procedures()
        self._online.shutdown(wait=True, cancel_futures=True)
        for computer in (self.online, self.computing):
            computer.close()
