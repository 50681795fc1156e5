"""The process that owns every device: engine and queue, no web."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress

import structlog

from drivers.errors import DeviceError, DeviceLost
from platform_daemon.analysis import Library
from platform_daemon.app import hardware_workers, start_engine
from platform_daemon.engine import Engine, JobRecords, open_catalogue
from platform_daemon.link import (
    STOPPED,
    Folders,
    HardwareLauncher,
    LinkServer,
    OwnedHardware,
    StoppedMeanwhile,
    stop_mark,
)
from platform_daemon.schedules import ScheduleKeeper, Schedules, rest_mark
from platform_daemon.settings import load_platform
from platform_daemon.store import DataFolder, EventJournal, Mark, StorageError, open_data_folder
from platform_daemon.workers import WorkerLimits

from .child import READY, Life
from .logs import LOGS, keep_log
from .options import ServeOptions
from .process import wait_for_signals

log = structlog.get_logger()
_AGAIN_S = 1.0  # devices that did not open are tried at most so often


def run_hardware(options: ServeOptions, life: Life) -> None:
    """Until it is told to end.  Raises InputError, OSError."""
    file = load_platform(options.platform, options.overrides, options.endpoints)
    if not life.wait_to_go():
        return
    folder = open_data_folder(options.data)
    life.follow()
    keep_log(options.data / LOGS, "hardware")
    catalogue = open_catalogue(folder.resonators, folder.sequences, options.resonators, folder.presets)
    kept = JobRecords(folder.jobs), Library(folder.models), catalogue
    limits = WorkerLimits().changed(options.worker_limits)
    events = EventJournal(folder.events)

    def start() -> Engine:
        return start_engine(file, *kept, *hardware_workers(limits), data=options.data, tell=events.tell)

    mark = stop_mark(options.data)
    opening = Opening(start, folder, mark, limits, forget=options.forget_queue)
    server = None
    launcher = HardwareLauncher(opening.hardware, kept[0], folder.recordings)
    ledger = options.data / "schedules.db"
    schedules = ScheduleKeeper(lambda: Schedules(ledger, launcher, tell=events.tell), rest_mark(ledger))
    try:
        opening.schedules = schedules
        if mark.stands:
            opening.stopped()
        opening.open()
        schedules.open()
        server = LinkServer(opening.hardware, options.data, opening.stopped)
        opening.listens()
        life.say(READY)
        wait_for_signals()
    except KeyboardInterrupt:
        pass
    finally:
        schedules.stop_starting()
        opening.close()
        schedules.close()
        if server is not None:
            server.close()
        events.close()


class Opening:
    """The engine, once its devices have opened; until then every request tries again.

    start: makes the engine; mark: of those who wanted everything stopped and found nobody; limits: of planning;
    forget: cancel what waited when the daemon ended.
    """

    def __init__(
        self, start: Callable[[], Engine], folder: DataFolder, mark: Mark, limits: WorkerLimits, *, forget: bool
    ) -> None:
        self._start, self._mark, self._limits, self._forget, self._stops = start, mark, limits, forget, 0
        self._folders = Folders(
            folder.recordings, folder.procedures, folder.characterisations, folder.calibrations, folder.mounted
        )
        self._engine: Engine | None = None
        self._hardware: OwnedHardware | None = None
        self._error: DeviceError = DeviceLost("the devices are being opened", remedy="ask again in some seconds")
        self._tried_s = -_AGAIN_S
        self._lock = threading.Lock()
        self._closed = False
        self.schedules: ScheduleKeeper | None = None

    def open(self) -> None:
        """Try to open the devices; one that cannot be opened is logged.  Raises InputError."""
        with self._lock:
            if self._hardware is not None or self._closed:
                return
            try:
                self._engine = self._start()
            except DeviceError as error:
                if str(error) != str(self._error):  # said once
                    log.error("devices_not_open", error=str(error))
                self._error = error
            else:
                self._take_up(self._engine)
            self._tried_s = time.monotonic()

    def _take_up(self, engine: Engine) -> None:
        owned = OwnedHardware(engine, self._folders, self.schedules, self._mark, self._limits)
        self._hardware = owned  # first: a stop must reach what is queued
        if self._closed:  # it is told to end: what waits does so for the next one
            return
        owned.take_up_queue(self._why_to_forget)
        if self._stops:
            self._mark.forget()
        engine.warm_up_fits()

    def _why_to_forget(self) -> str | None:
        if self._stops or self._mark.stands:
            return STOPPED
        return "forgotten when the daemon was started (--forget-queue)" if self._forget else None

    def stopped(self) -> None:
        """Everything is to stop, while nobody may be there to be told: what waits does not begin later, in another
        process neither."""
        if self._hardware is None:
            self._stops += 1
            with suppress(StorageError):  # what it says is known here
                self._mark.leave()
            if self.schedules is not None:
                self.schedules.pause_all(STOPPED)

    def listens(self) -> None:
        """From now on whoever wants to stop reaches this process; those who did not are heard now."""
        if not self._mark.stands:
            return
        self.stopped()
        if self._hardware is not None:
            try:
                self._hardware.outputs_off()
            except DeviceError as error:  # all is cancelled; what it cannot prove off stands as a fault
                log.error("outputs_not_proved_off", error=str(error))

    def hardware(self) -> OwnedHardware:
        """Who answers now.  Raises DeviceError while devices cannot be opened, and if a stop came meanwhile."""
        stops = self._stops
        if self._hardware is None and not self._lock.locked() and time.monotonic() - self._tried_s >= _AGAIN_S:
            self.open()
        if self._hardware is None:
            raise self._error
        if stops != self._stops:
            what, remedy = "everything was stopped while the devices were opened", "ask again if it is to be done"
            raise StoppedMeanwhile(what, remedy=remedy)
        return self._hardware

    def close(self) -> None:
        """Outputs off, what runs cancelled, what waits left for the next start, devices let go.  Idempotent."""
        self._closed = True
        if self._hardware is not None and self._engine is not None:  # also while it takes the queue up
            self._engine.close(keep_queue=True)
        with self._lock:
            if self._engine is not None:
                self._engine.close(keep_queue=True)
