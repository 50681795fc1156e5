"""The platform service of this process, which owns the hardware."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, Protocol

from drivers.errors import DeviceStateError, InputError, PlatformError
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.jobs import AnyJob, Work
from platform_daemon.core.jobs.submit_options import SubmitOptions
from platform_daemon.core.jobs.workers.deadline import deadline
from platform_daemon.core.jobs.workers.limits import WorkerLimits
from platform_daemon.core.registry import feature_of
from platform_daemon.core.schemas.acquisitions import ShotPage
from platform_daemon.core.schemas.base import QueuedRequest, Schema
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
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.state.flag_file import FlagFile

from .bench import Folders, HardwareBench
from .job_view import JobView
from .mounted import Mounted
from .queue import take_up_queue
from .queue_edits import check_resumable, edit_waiting, put_in_order
from .stopping import STOPPED
from .submit_once import SubmitOnce


class StopsWithAll(Protocol):
    """What starts work by itself, and must not after a stop: the schedules."""

    def suspend(self, reason: str) -> None:
        """Start nothing more, as of now."""

    def pause_all(self, reason: str) -> StorageError | None:
        """Keep that on disk; why it could not be kept."""


class LocalPlatformService:
    """See PlatformService.

    starts: the schedules, None: there are none; mark: flag of a stop that no hardware process answered; limits: of
    planning, None: those of the registry.
    """

    def __init__(
        self,
        engine: Engine,
        folders: Folders,
        starts: StopsWithAll | None = None,
        mark: FlagFile | None = None,
        limits: WorkerLimits | None = None,
    ) -> None:
        self._engine, self._folders = engine, folders
        self._starts, self._mark = starts, mark
        self._taking_up = threading.Lock()
        self._once = SubmitOnce()
        self._planning_bounds = (limits or WorkerLimits()).of("planning")
        self._mounted = Mounted(folders.mounted, changes_itself=engine.platform.changes_resonators)

    @property
    def engine(self) -> Engine:
        """The engine of this process."""
        return self._engine

    @property
    def stops(self) -> int:
        """How often everything was stopped."""
        return self._engine.stops

    def busy(self) -> bool:
        """Does something run, or wait that will begin by itself?"""
        engine = self._engine
        busy = engine.status().running is not None or engine.conducts or engine.queue.awaits
        return busy or self._taking_up.locked()

    def submit(self, kind: str, request: Any, options: SubmitOptions | None = None) -> JobView:
        """See JobService; options: None, a new job and now."""
        options = options or SubmitOptions(stops=self.stops)  # before it is planned: a stop meanwhile holds for it
        work = self.plan(kind, request)
        self._note_mounted(request)
        return JobView.of(self._engine.submit(work, options=options))

    def submit_once(self, kind: str, request: Any, key: str) -> JobView:
        """See JobService."""
        stops = self.stops  # before the job of another submission is waited for

        def submit(identifier: str) -> JobView:
            return self.submit(kind, request, SubmitOptions(identifier, stops=stops))

        return self._once.job(self, kind, request, key, submit)

    def plan(self, kind: str, request: Any, again: AnyJob | None = None, *, resumes: bool = False) -> Work[Any, Any]:
        """The checked work of a request; again, resumes: see HardwareBench.  Raises as `submit`."""
        feature = feature_of(kind)
        if not feature.kind.needs_hardware:
            raise InputError(f"a {kind} does not need the platform", where="kind", remedy="ask the web process")
        bench = HardwareBench(engine=self._engine, folders=self._folders, again=again, resumes=resumes)
        work: Work[Any, Any] = self._in_time(lambda: feature.load(feature.kind.plan)(bench, request), again)
        return work

    def dry_run(self, kind: str, request: Any) -> Schema:
        """See JobService."""
        feature = feature_of(kind)
        if not feature.kind.dry_run:
            raise InputError(
                f"a {kind} has no dry run", where="kind", remedy="submit it: it is checked before it moves"
            )
        bench = HardwareBench(engine=self._engine, folders=self._folders)
        found: Schema = self._in_time(lambda: feature.load(feature.kind.dry_run)(bench, request))
        return found

    def job_ids(self, kind: str) -> tuple[str, ...]:
        """See JobService."""
        return self._engine.job_ids(kind)

    def job_ids_in(self, kind: str, states: tuple[JobState, ...]) -> tuple[str, ...]:
        """See JobService."""
        return self._engine.job_ids_in(kind, states)

    def jobs(self, kind: str, identifiers: tuple[str, ...]) -> tuple[JobView, ...]:
        """See JobService."""
        return tuple(JobView.of(self._engine.job(kind, each)) for each in identifiers)

    def job(self, kind: str, identifier: str) -> JobView:
        """See JobService."""
        return JobView.of(self._engine.job(kind, identifier))

    def cancel(self, kind: str, identifier: str) -> JobView:
        """See JobService."""
        self._engine.job(kind, identifier).request_cancel()
        return self.job(kind, identifier)  # another one may have come in its place

    def pause(self, kind: str, identifier: str) -> JobView:
        """See PlatformService."""
        return self._ask_pause(kind, identifier, pause=True)

    def resume(self, kind: str, identifier: str) -> JobView:
        """See PlatformService."""
        job = self._engine.job(kind, identifier)
        if not (job.state.final and feature_of(kind).kind.resumable):
            return self._ask_pause(kind, identifier, pause=False)
        check_resumable(job)
        options = SubmitOptions(again=job, stops=self.stops)
        work = self.plan(kind, job.request, job, resumes=True)
        return JobView.of(self._engine.submit(work, options=options))

    def edit(self, kind: str, identifier: str, request: Any) -> JobView:
        """See PlatformService."""
        job = edit_waiting(self._engine, self._engine.job(kind, identifier), lambda: self.plan(kind, request))
        self._note_mounted(request)
        return JobView.of(job)

    def order(self, request: QueueOrder) -> PlatformStatus:
        """See PlatformService."""
        put_in_order(self._engine, request.order, request.priority)
        return self.status()

    def answer(self, kind: str, identifier: str) -> JobView:
        """See PlatformService."""
        job = self._engine.job(kind, identifier)
        if job.question is None:
            what = f"the {job.kind} does not wait for anything"
            raise DeviceStateError(what, where=job.identifier, remedy="look at `state`")
        job.proceed.set()
        return self.job(kind, identifier)

    def status(self) -> PlatformStatus:
        """See PlatformService."""
        return self._engine.status()

    def devices(self) -> DeviceListing:
        """See PlatformService."""
        return self._engine.devices()

    def warm(self) -> dict[str, bool]:
        """See PlatformService."""
        return self._engine.warm

    def last_harmonics(self) -> ShotHarmonics | None:
        """See PlatformService."""
        return self._engine.live.latest

    def shots(self, kind: str, identifier: str, after: int, limit: int) -> ShotPage:
        """See PlatformService."""
        return self._engine.job(kind, identifier).shots.page(identifier, after=after, limit=limit)

    def outputs_off(self) -> StopReport:
        """See PlatformService.  Schedules start nothing more until an operator resumes them."""
        starts = self._starts
        if starts is not None:
            starts.suspend(STOPPED)  # first: work that they start from now on counts as requested after the stop
        unproved = None
        try:
            self._engine.outputs_off(left=True)
        except PlatformError as refused:  # all is cancelled nevertheless
            unproved = refused
        if self._mark is not None:
            self._mark.clear()
        error = None if starts is None else starts.pause_all(STOPPED)
        if unproved is not None:
            raise unproved
        later = "" if error is None else f"; schedules rest, but that is not in their ledger yet: {error}"
        if self._engine.unsaved:
            later += f"; of {self._engine.unsaved} it is not on the disk, which refuses"
        return StopReport(status=f"outputs are off, acquisitions are cancelled{later}")

    def reset_fault(self) -> FaultReset:
        """See PlatformService."""
        return self._engine.reset_fault()

    def unlock(self, request: FaultUnlock) -> FaultCleared:
        """See PlatformService."""
        fault = self._engine.unlock(request.by, request.reason)
        if fault is not None:  # what waited when the daemon was started
            self.take_up_queue()
        return FaultCleared(fault=fault, by=request.by)

    def activate(self, request: ActivationRequest) -> CalibrationsInUse:
        """See PlatformService."""
        if not self._taking_up.acquire(blocking=False):
            what, remedy = "what waited when the daemon ended is being planned", "repeat the request in some seconds"
            raise DeviceStateError(what, where="calibration", remedy=remedy)
        try:
            return self._engine.activate(request, self._folders.calibrations)
        finally:
            self._taking_up.release()

    def take_up_queue(self, forget: Callable[[], str | None] = lambda: None) -> None:
        """See `take_up_queue`."""
        with self._taking_up:
            take_up_queue(self._engine, self.take_up, forget)

    def take_up(self, job: AnyJob) -> None:
        """Queue a job of an earlier run that waits again, under its id.  Raises InputError, WaitsNoMore."""
        resumed = getattr(job.result, "recording", None) is not None  # and had to wait
        work = self.plan(job.kind, job.request, job, resumes=resumed)
        self._engine.submit(work, options=SubmitOptions(again=job, waits=True))

    def mounted(self) -> MountedResonator:
        """See PlatformService."""
        return self._mounted.now()

    def set_mounted(self, request: MountRequest) -> MountedResonator:
        """See PlatformService."""
        self._engine.catalogue.resonators.named(request.resonator)
        return self._mounted.say(request.resonator, request.by)

    def not_mounted(self, resonator: str, *, surely: bool) -> str | None:
        """See Mounted.missing."""
        return self._mounted.missing(resonator, surely=surely)

    def _note_mounted(self, request: QueuedRequest) -> None:
        """A request that measures a resonator reports it as mounted."""
        if (resonator := request.mounted_resonator) is not None:
            self._mounted.say(resonator, None)

    def _ask_pause(self, kind: str, identifier: str, *, pause: bool) -> JobView:
        """Of a job that waits it is kept, so that it does not begin after a restart either."""
        job = self._engine.job(kind, identifier)
        if not job.ask_pause(pause=pause):
            remedy = "ask for the steps that are missing as a new procedure"
            raise DeviceStateError(f"the {job.kind} has ended", where=job.identifier, why=str(job.state), remedy=remedy)
        return self.job(kind, identifier)

    def _in_time(self, plan: Callable[[], Any], again: AnyJob | None = None) -> Any:
        """What was found feasible once is planned without a time limit."""
        if again is not None:
            return plan()
        with deadline("planning", self._planning_bounds):
            return plan()
