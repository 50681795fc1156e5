"""Puts the parts together: platform file -> platform -> engine -> API."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

from drivers.calibration import ReceiveCalibration, TransmitCalibration
from drivers.errors import ConfigError
from drivers.platform import Platform
from drivers.registry import build_platform
from platform_daemon.core.guard.guard_client import guard_for
from platform_daemon.core.hardware.calibration_in_use import CalibrationFiles, read_receive
from platform_daemon.core.hardware.catalogue import Catalogue, open_catalogue
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.events import EventSink, null_sink
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.workers.limits import WorkerLimits
from platform_daemon.core.jobs.workers.process import WorkerProcess
from platform_daemon.core.jobs.workers.process_pool import ProcessPool
from platform_daemon.core.jobs.workers.task_executor import InProcessExecutor, TaskExecutor
from platform_daemon.core.recordings.calibrations import read_transmit_calibration
from platform_daemon.core.recordings.data_folder import DataFolder
from platform_daemon.core.schemas.events import AnyEvent
from platform_daemon.core.service.analysis_jobs import AnalysisJobs
from platform_daemon.core.service.platform_service import PlatformService
from platform_daemon.core.service.proxy import PlatformServiceProxy
from platform_daemon.core.settings import PlatformFile
from platform_daemon.features.alarms.schema import Alarm
from platform_daemon.features.fit.online import Warmth
from platform_daemon.features.self_test.work import chain_test
from platform_daemon.features.tune.presets import TunedPresets

if TYPE_CHECKING:
    from platform_daemon.core.web.context import Context

# Shots come before all that is computed, and what the hardware process computes before the analyses of the web process.
_NICE_HARDWARE, _NICE_WEB = 5, 10


def start_engine(
    file: PlatformFile,
    journal: JobRecords | None = None,
    models: Path | None = None,
    catalogue: Catalogue = Catalogue(),  # noqa: B008 frozen
    online: TaskExecutor = InProcessExecutor(),  # noqa: B008 without state
    computing: TaskExecutor = InProcessExecutor(),  # noqa: B008 without state
    data: Path | None = None,
    tell: EventSink = null_sink,
    *,
    warms_up: bool = True,
) -> Engine:
    """An engine on the platform that the file describes; outputs are off.

    online: computes on-line fits and plans; computing: what takes longer; data: data folder of a daemon; tell: takes
    events; warms_up: see Engine.  Raises ConfigError, DeviceError, DeviceDenied if another process owns the devices.
    """
    calibration = None if file.calibration_file is None else read_receive(file.calibration_file)
    transmit = None if file.transmit_file is None else read_transmit_calibration(file.transmit_file)
    named = CalibrationFiles(file.calibration_file, file.transmit_file)
    guard = guard_for(file.section, file.limits.max_lease_s, data)  # before any device is opened: another may own them
    try:
        platform = _built(file, calibration, transmit)
    except BaseException:
        guard.close()
        raise
    platform.guard = guard
    try:
        guard.watch()
        return Engine(
            platform,
            file.limits,
            file.text,
            journal=journal,
            models=models,
            make_chain_test=partial(chain_test, platform, file.self_test),
            files=named,
            catalogue=catalogue,
            online=online,
            computing=computing,
            warm_up=Warmth,
            tell=tell,
            warms_up=warms_up,
        )
    except BaseException:  # Ctrl-C too
        platform.close()
        raise


def _built(
    file: PlatformFile, calibration: ReceiveCalibration | None, transmit: TransmitCalibration | None
) -> Platform:
    """Raises ConfigError that names the file, DeviceError."""
    try:
        return build_platform(file.section, calibration, transmit)
    except ConfigError as error:
        where = f"{file.path}: {error.where}" if error.where else str(file.path)
        raise ConfigError(error.what, where=where, why=error.why, remedy=error.remedy) from None


def kept_catalogue(data: Path, presets: Path | None) -> Catalogue:
    """What ships, with what a data folder holds: resonators with the limits of ramps, sequences, and the presets of
    tune.  presets: another folder of these."""
    return open_catalogue(data / "resonators", data / "sequences", None, TunedPresets(presets or data / "presets"))


def create_context(
    hardware: PlatformServiceProxy,
    data: DataFolder,
    catalogue: Catalogue,
    limits: WorkerLimits | None = None,
    tell: EventSink = null_sink,
    call: Callable[[Alarm], None] = lambda alarm: None,
    idle_s: float | None = None,
) -> Context:
    """What the API serves.

    limits: of the worker processes, None: those of the registry; tell: takes events; call: for each alarm; idle_s: one
    is raised when nothing has begun for so long, None: none is.
    """
    # Here, because the process that owns the hardware, and a command that measures, need neither alarms nor web.
    from platform_daemon.core.web.context import Context
    from platform_daemon.core.web.event_tail import EventTail
    from platform_daemon.core.web.metrics import Metrics
    from platform_daemon.core.web.network.limits import Limits
    from platform_daemon.features.alarms.board import AlarmBoard
    from platform_daemon.features.alarms.watch import Watch, Watched
    from platform_daemon.features.measurand.online import OnlineReadings
    from platform_daemon.features.trends.index_keeper import TrendKeeper

    # One for the analyses, which run one after the other, and one for each request that may compute at the same time.
    executor = ProcessPool("analyses", 1 + Limits().computing, limits or WorkerLimits(), nice=_NICE_WEB)
    service = cast(PlatformService, hardware)
    board = AlarmBoard(data.state, tell, call)
    metrics = Metrics(service, lambda: len(board.standing()), data.recordings)
    watched = Watched(data.recordings, data.events, data.events_seen, idle_s=idle_s)
    readings = OnlineReadings(data.measurands, catalogue, tell)

    def see(what: AnyEvent) -> None:
        metrics.see(what)
        readings.see(what)

    watch = Watch(watched, board, service.status, see, hardware.service("schedules").list)
    return Context(
        hardware=service,
        feature_service=hardware.service,
        catalogue=catalogue,
        analyses=AnalysisJobs(executor, data, JobRecords(data.state), tell),
        executor=executor,
        folders=data,
        events=EventTail(data.events, hardware.invalidate),
        metrics=metrics,
        parts={Watch: watch, AlarmBoard: board, TrendKeeper: TrendKeeper(data.recordings, board)},
    )


def hardware_workers(limits: WorkerLimits) -> tuple[WorkerProcess, WorkerProcess]:
    """The workers of the process that owns the hardware: of on-line fits and plans, and of what takes longer.

    They are no pool: an on-line fit must find the process whose kernels are compiled, and never wait for a procedure.
    """
    return WorkerProcess("fits", limits, _NICE_HARDWARE), WorkerProcess("procedures", limits, _NICE_HARDWARE)
