"""The engine: owner of the platform.  One hardware thread works through a queue; fits run in other processes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import structlog

from drivers.errors import DeviceStateError, PlatformError
from drivers.platform import Platform
from platform_daemon.core.jobs.events import EventSink, null_sink
from platform_daemon.core.jobs.hardware_queue import HardwareQueue
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.job_registry import JobRegistry
from platform_daemon.core.jobs.jobs import AnyJob, Job, RequestT, ResultT, Work
from platform_daemon.core.jobs.submit_options import SUBMIT_NOW, ShuttingDown, SubmitOptions, WaitsNoMore
from platform_daemon.core.jobs.workers.task_executor import InProcessExecutor, Task, TaskExecutor
from platform_daemon.core.registry import kinds
from platform_daemon.core.schemas.calibrations import CalibrationsInUse
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.platform import DeviceListing, FaultReset, PlatformStatus
from platform_daemon.core.schemas.requests import ActivationRequest
from sequences.compiler import TransmitSide
from sequences.limits import SafetyLimits

from .calibration_in_use import CalibrationFiles, CalibrationInUse, MakeChainTest, NoChainTest
from .catalogue import Catalogue
from .hardware_thread import HardwareThread
from .interlock import Interlock
from .live_estimate import LiveEstimate
from .readback import Readback
from .reset_fault import reset_amplifier
from .warm_up import WarmUp

log = structlog.get_logger()


class Engine:
    """Runs acquisitions one after the other on one platform, and their fits meanwhile.

    config_text is stored in every recording; models: folder of adopted models; make_chain_test: makes the test that
    comes before each series and each transmit calibration; files: calibrations that the platform file names;
    catalogue: what can be measured by name; online: computes on-line fits and plans; computing: what takes longer;
    warm_up: makes the task that loads what the first on-line fit needs; tell: takes events; warms_up: whether the
    platform is warmed up for the first shot, False: none will be made, as in a dry run.

    On-line fits have a thread.  Raises SequenceRejected if the chain test leaves the limits.
    """

    def __init__(
        self,
        platform: Platform,
        limits: SafetyLimits,
        config_text: str,
        journal: JobRecords | None = None,
        models: Path | None = None,
        make_chain_test: MakeChainTest = NoChainTest,
        files: CalibrationFiles = CalibrationFiles(),  # noqa: B008 frozen
        catalogue: Catalogue = Catalogue(),  # noqa: B008 frozen
        online: TaskExecutor = InProcessExecutor(),  # noqa: B008 without state
        computing: TaskExecutor = InProcessExecutor(),  # noqa: B008 without state
        warm_up: Callable[[], Task[float]] = lambda: _nothing,
        tell: EventSink = null_sink,
        *,
        warms_up: bool = True,
    ) -> None:
        self.platform = platform
        self.config_text = config_text
        self.live = LiveEstimate()
        self.catalogue = catalogue
        self.calibration_in_use = CalibrationInUse(platform, limits, make_chain_test, files)
        self.models, self.online, self.computing = models, online, computing
        self._registry = JobRegistry(journal or JobRecords(None), kinds(on_hardware=True), tell)
        self.tell = tell
        self.fits = ThreadPoolExecutor(max_workers=1, thread_name_prefix="online-fits")
        self._planning = threading.RLock()  # held while a job is made from what the platform is now
        self._closed = self._registry.ends
        self.stops = 0  # how often everything was stopped
        self._interlock = Interlock(platform, tell)
        self._warm_up = WarmUp(self.fits, online, warm_up)
        self._readback = Readback(platform, tell)
        self._readback.refresh()
        self._hardware = HardwareThread(platform, self._interlock, self._readback, self._closed, warms_up=warms_up)

    @property
    def side(self) -> TransmitSide:
        """What sequences are planned for now."""
        return self.calibration_in_use.side

    @property
    def queue(self) -> HardwareQueue:
        """What waits for the hardware."""
        return self._hardware.queue

    def read_back_in_shot(self) -> None:
        """Read back all devices but the card, which is busy; for the RX window of a long shot."""
        self._hardware.refresh(busy=True)

    def submit(
        self, work: Work[RequestT, ResultT], within: AnyJob | None = None, options: SubmitOptions = SUBMIT_NOW
    ) -> Job[RequestT, ResultT]:
        """Queue work on the hardware: it runs behind the interlock once those before it have ended.

        A procedure submits its steps itself; what stops the procedure stops its step.  A job that was requested before
        a stop of everything is cancelled.  Raises ShuttingDown, InterlockError while a fault is latched, WaitsNoMore.
        """
        self._interlock.refuse()
        with self._planning:
            if self._closed.is_set():
                raise ShuttingDown("the daemon is shutting down", remedy="start it again, then submit the job again")
            job = self._registered(work, within, options)
            if options.stops is not None and options.stops != self.stops:  # now a later stop finds the job
                job.request_cancel()
            self._hardware.put(job, work)
            return job

    def _registered(
        self, work: Work[RequestT, ResultT], within: AnyJob | None, options: SubmitOptions
    ) -> Job[RequestT, ResultT]:
        """A new job in the registry, on the disk, not yet in the queue of the hardware thread.

        within: the procedure whose step it is.  With `options.again` it takes the id of a job of an earlier run: of one
        that has ended, whose missing shots are measured now, or of one that still waits and becomes its `successor`.
        Raises DeviceStateError if that one is queued or runs, WaitsNoMore if it was cancelled.
        """
        if options.again is not None and not options.waits:
            known = self.job(options.again.kind, options.again.identifier)
            if known is not options.again and not known.state.final:
                what, where = "its missing shots are queued", known.identifier
                raise DeviceStateError(what, where=where, remedy="wait for them")
        if not options.waits or options.again is None:
            job = self._job_of(work, within, options)
            self._registry.add(job, queued=True)
            return job
        with options.again.held() as waits:  # commands to the earlier job count until here, then those to this one
            if not waits:
                raise WaitsNoMore("it was cancelled", where=options.again.identifier)
            job = self._job_of(work, within, options)
            self._registry.add(job, queued=True)
            options.again.successor = job
            return job

    def _job_of(
        self, work: Work[RequestT, ResultT], within: AnyJob | None, options: SubmitOptions
    ) -> Job[RequestT, ResultT]:
        job = Job.of(work, within, options.again, options.identifier)
        job.platform_clock = self.platform.clock.kind
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

    def job_ids_in(self, kind: str, states: Collection[JobState]) -> tuple[str, ...]:
        """Ids of the jobs of a kind that are in one of these states, oldest first.  Raises StorageError."""
        return self._registry.ids_in(kind, states)

    def status(self) -> PlatformStatus:
        """Devices as last read back (a second ago while idle, in the RX window of a long shot), and the job."""
        jobs, in_use = self._registry, self.calibration_in_use.in_use()
        waiting = tuple(job.identifier for job in self.queue.jobs())
        return self._readback.status(in_use, self._interlock.stands, jobs.running, waiting)

    def devices(self) -> DeviceListing:
        """Each device as last read back: identity, state, the error if it did not answer, and its last error."""
        return DeviceListing(items=self._readback.devices)

    @property
    def warm(self) -> dict[str, bool]:
        """By part: has it done what takes long the first time?  Jobs wait for the platform."""
        return {"platform": self._hardware.warm.is_set(), "estimator": self._warm_up.done.is_set()}

    def warm_up_fits(self) -> None:
        """Have the estimator's kernels loaded, or compiled, there where on-line fits are made, before the first."""
        self._warm_up.begin()

    def outputs_off(self, *, left: bool = False) -> None:
        """Switch everything off now, from any thread, and cancel all jobs that move something or wait to do so.

        left: also cancel jobs of an earlier run that have not been queued again.
        """
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

    def close(self, *, keep_queue: bool = False, killed: str | None = None) -> None:
        """Outputs off, jobs cancelled, threads ended, devices let go.  Idempotent.

        keep_queue: what has not begun stays as it is, for the next start; killed: see JobRegistry.say_ended.
        """
        if self._closed.is_set():
            return
        self._closed.set()  # no lock yet: none may hold up outputs off
        ends = self._registry.begun if keep_queue else self._registry.all
        try:
            self._registry.say_ended(killed)
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
        self.fits.shutdown(wait=True, cancel_futures=True)
        for executor in (self.online, self.computing):
            executor.close()


def _nothing(tell: Any) -> float:
    return 0.0
