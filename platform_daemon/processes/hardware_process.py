"""The hardware process: it owns every device, the engine and the queue, and has no web server."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import structlog

from drivers.errors import DeviceError, DeviceLost
from platform_daemon.core.hardware.catalogue import open_catalogue
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.workers.limits import WorkerLimits
from platform_daemon.core.recordings.data_folder import DataFolder, open_data_folder
from platform_daemon.core.service.bench import Folders
from platform_daemon.core.service.local import LocalPlatformService
from platform_daemon.core.service.server import LinkServer
from platform_daemon.core.service.stopping import STOPPED, StoppedMeanwhile, stop_mark
from platform_daemon.core.settings import load_platform
from platform_daemon.core.state.errors import StorageError
from platform_daemon.core.state.event_journal import EventJournal
from platform_daemon.core.state.flag_file import FlagFile
from platform_daemon.core.state.logs import LOGS, keep_log
from platform_daemon.features.schedules.launch_work import HardwareLauncher
from platform_daemon.features.schedules.schedules import Schedules
from platform_daemon.features.tune.presets import TunedPresets

from .assembly import hardware_workers, start_engine
from .child import READY, ParentLink
from .options import ServeOptions
from .process import wait_for_signals

log = structlog.get_logger()
_RETRY_S = 1.0  # devices that did not open are tried again at most so often


def run_hardware(options: ServeOptions, parent: ParentLink) -> None:
    """Run the process until it receives the signal to end.  Raises InputError, DamagedDatabase, OSError."""
    file = load_platform(options.platform, options.overrides, options.endpoints)
    if not parent.wait_to_go():
        return
    folder = open_data_folder(options.data, lambda: keep_log(options.data / LOGS, "hardware"))
    parent.end_with_parent()
    catalogue = open_catalogue(folder.resonators, folder.sequences, options.resonators, TunedPresets(folder.presets))
    records = JobRecords(folder.state)
    if not options.respawned:  # one that is started again must come up whatever the file is like: a stop needs it
        records.check()
    limits = WorkerLimits().changed(options.worker_limits)
    events = EventJournal(folder.events)

    def start() -> Engine:
        online, computing = hardware_workers(limits)
        return start_engine(
            file,
            journal=records,
            models=folder.models,
            catalogue=catalogue,
            online=online,
            computing=computing,
            data=options.data,
            tell=events.tell,
        )

    mark = stop_mark(options.data)
    opener = EngineOpener(start, folder, mark, limits, forget=options.forget_queue)
    server = None
    launcher = HardwareLauncher(opener.hardware, records, folder.recordings)
    schedules = Schedules(folder.schedules, launcher, tell=events.tell)
    try:
        opener.schedules = schedules
        if mark.is_set:
            opener.stop_requested()
        opener.open()
        schedules.start()
        server = LinkServer(opener.service, options.data, opener.stop_requested)
        opener.server_started()
        parent.report(READY)
        wait_for_signals()
    except KeyboardInterrupt:
        pass
    finally:
        schedules.stop_starting()
        opener.close(killed=parent.how_killed)
        schedules.close()
        if server is not None:
            server.close()
        events.close()


class EngineOpener:
    """Opens the devices and holds the engine; while devices do not open, requests try again.

    start: makes the engine; mark: is left by a stop that reached no hardware process; limits: of planning; forget:
    cancel the jobs that waited when the daemon ended.
    """

    def __init__(
        self, start: Callable[[], Engine], folder: DataFolder, mark: FlagFile, limits: WorkerLimits, *, forget: bool
    ) -> None:
        self._start = start
        self._mark = mark
        self._limits = limits
        self._forget = forget
        self._stops = 0
        self._folders = Folders(
            recordings=folder.recordings,
            procedures=folder.procedures,
            characterisations=folder.characterisations,
            reproductions=folder.reproductions,
            calibrations=folder.calibrations,
            mounted=folder.mounted,
        )
        self._engine: Engine | None = None
        self._hardware: LocalPlatformService | None = None
        self._error: DeviceError = DeviceLost(
            "the devices are being opened", remedy="repeat the request in some seconds"
        )
        self._tried_s = -_RETRY_S
        self._lock = threading.Lock()
        self._closed = False
        self.schedules: Schedules | None = None

    def open(self) -> None:
        """Try to open the devices; a device that cannot be opened is logged.  Raises InputError."""
        with self._lock:
            if self._hardware is not None or self._closed:
                return
            try:
                self._engine = self._start()
            except DeviceError as error:
                if str(error) != str(self._error):  # logged once
                    log.error("devices_not_open", error=str(error))
                self._error = error
            else:
                self._take_up(self._engine)
            self._tried_s = time.monotonic()

    def _take_up(self, engine: Engine) -> None:
        owned = LocalPlatformService(engine, self._folders, self.schedules, self._mark, self._limits)
        self._hardware = owned  # first: a stop must reach queued jobs
        if self._closed:  # the process ends: jobs wait for the next one
            return
        owned.take_up_queue(self._why_to_forget)
        if self._stops:
            self._mark.clear()
        engine.warm_up_fits()

    def _why_to_forget(self) -> str | None:
        if self._stops or self._mark.is_set:
            return STOPPED
        return "forgotten when the daemon was started (--forget-queue)" if self._forget else None

    def stop_requested(self) -> None:
        """Stop everything, although there may be no engine yet: jobs that wait must not begin later, in a later process
        neither."""
        if self._hardware is None:
            self._stops += 1
            with suppress(StorageError):  # this process knows of the stop
                self._mark.set()
            if self.schedules is not None:
                self.schedules.pause_all(STOPPED)

    def server_started(self) -> None:
        """From now on a stop reaches this process; one that left its mark before takes effect now."""
        if not self._mark.is_set:
            return
        self.stop_requested()
        if self._hardware is not None:
            try:
                self._hardware.outputs_off()
            except DeviceError as error:  # all jobs are cancelled; what cannot be proved off is a fault
                log.error("outputs_not_proved_off", error=str(error))

    def hardware(self) -> LocalPlatformService:
        """The service over the engine.  Raises DeviceError while no device opens, or if a stop came meanwhile."""
        stops = self._stops
        if self._hardware is None and not self._lock.locked() and time.monotonic() - self._tried_s >= _RETRY_S:
            self.open()
        if self._hardware is None:
            raise self._error
        if stops != self._stops:
            what, remedy = "everything was stopped while the devices were opened", "ask again if it is to be done"
            raise StoppedMeanwhile(what, remedy=remedy)
        return self._hardware

    def service(self, name: str) -> Any:
        """The service of that name: "" is the platform service, another one that of a feature.

        Raises as `hardware`, StorageError while the schedules cannot be used, LookupError for a name that is none.
        """
        if name == "":
            return self.hardware()
        if name == "schedules" and self.schedules is not None:
            return self.schedules
        raise LookupError(f"no service is called {name!r}")

    def close(self, *, killed: str | None = None) -> None:
        """Outputs off, running jobs cancelled, waiting jobs left for the next start, devices closed.  Idempotent.

        killed: how the daemon was ended, if nobody told it to end; running jobs have failed then.
        """
        self._closed = True
        if self._hardware is not None and self._engine is not None:  # also while it takes up the queue
            self._engine.close(keep_queue=True, killed=killed)
        with self._lock:
            if self._engine is not None:
                self._engine.close(keep_queue=True, killed=killed)
