"""Puts the parts together: platform file -> platform -> engine -> API."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.calibration import ReceiveCalibration, TransmitCalibration
from drivers.errors import ConfigError
from drivers.platform import Platform
from drivers.registry import build_platform
from platform_daemon.alarms import AlarmBoard, Watch, Watched
from platform_daemon.analysis import Library
from platform_daemon.engine import (
    AnalysisJobs,
    CalibrationFiles,
    Catalogue,
    Engine,
    JobRecords,
    Tell,
    quiet,
    read_receive,
)
from platform_daemon.link import Hardware
from platform_daemon.schemas import Alarm
from platform_daemon.settings import PlatformFile
from platform_daemon.store import DataFolder, read_transmit_calibration
from platform_daemon.supervisor import guard_for
from platform_daemon.workers import Computer, InThisProcess, Pool, WorkerLimits, WorkerProcess

if TYPE_CHECKING:
    from platform_daemon.api import Context

_NICE_FITS, _NICE_ANALYSES = 5, 10  # what somebody waits for comes first, and shots before all of it
_PREVIEWS = 2
_PREVIEW_PATIENCE_S = 20.0


def start_engine(
    file: PlatformFile,
    journal: JobRecords | None = None,
    models: Library | None = None,
    catalogue: Catalogue = Catalogue(),  # noqa: B008 frozen
    online: Computer = InThisProcess(),  # noqa: B008 without state
    computing: Computer = InThisProcess(),  # noqa: B008 without state
    data: Path | None = None,
    tell: Tell = quiet,
) -> Engine:
    """An engine on the platform that the file describes; outputs are off.

    online: computes on-line fits and plans; computing: what takes longer; data: data folder of a daemon; tell: takes
    events.  Raises ConfigError, DeviceError, DeviceDenied if another process owns the devices.
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
        known = journal, models, file.self_test, named, catalogue
        return Engine(platform, file.limits, file.text, *known, online, computing, tell)
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


def create_context(
    hardware: Hardware,
    data: DataFolder,
    catalogue: Catalogue,
    limits: WorkerLimits = WorkerLimits(),  # noqa: B008 frozen
    tell: Tell = quiet,
    call: Callable[[Alarm], None] = lambda alarm: None,
    idle_s: float | None = None,
) -> Context:
    """What the API serves.

    limits: of the processes that compute what is asked for; tell: takes events; call: for each alarm; idle_s: one is
    raised when nothing has begun for so long, None: none is.
    """
    # Here, because the process that owns the hardware needs no web.
    from platform_daemon.api import Context, EventTail, Metrics, TrendKeeper

    folders = data.recordings, data.fits, data.diagnoses, data.characterisations, data.procedures
    analyses = AnalysisJobs(WorkerProcess("analyses", limits, _NICE_ANALYSES), JobRecords(data.jobs), tell)
    previews = preview_workers(limits)
    alarms = AlarmBoard(data.alarms, tell, call)
    metrics = Metrics(hardware, alarms, data.recordings)
    watched = Watched(data.recordings, data.events, data.alarms.with_suffix(".seen"), idle_s=idle_s)
    watch = Watch(watched, alarms, hardware.status, metrics.see, hardware.list_schedules)
    return Context(
        *(hardware, catalogue, analyses, previews, *folders),
        *(Library(data.models), data.calibrations, EventTail(data.events, hardware.has_happened)),
        *(alarms, metrics, watch),
        trends=TrendKeeper(data.recordings, alarms),
    )


def hardware_workers(limits: WorkerLimits) -> tuple[WorkerProcess, WorkerProcess]:
    """Who computes for the process that owns the hardware: on-line fits and plans, and what takes longer."""
    return WorkerProcess("fits", limits, _NICE_FITS), WorkerProcess("procedures", limits, _NICE_FITS)


def preview_workers(limits: WorkerLimits) -> Pool:
    """Who computes what a request waits for."""
    from platform_daemon.api import too_many_previews

    each = [WorkerProcess(f"preview-{k}", limits, _NICE_FITS) for k in range(_PREVIEWS)]
    return Pool([*each], _PREVIEW_PATIENCE_S, too_many_previews)
