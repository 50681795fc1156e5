"""Puts the parts together: platform file -> platform -> engine -> API."""

from __future__ import annotations

import threading
from pathlib import Path

import structlog

from drivers.calibration import ReceiveCalibration, TransmitCalibration
from drivers.errors import ConfigError
from drivers.platform import Platform
from drivers.registry import build_platform
from platform_daemon.analysis import Library
from platform_daemon.api import Context
from platform_daemon.engine import AnalysisJobs, CalibrationFiles, Catalogue, Engine, JobRecords, read_receive
from platform_daemon.estimation import warm_up
from platform_daemon.link import Hardware
from platform_daemon.settings import PlatformFile
from platform_daemon.store import DataFolder, read_transmit_calibration
from platform_daemon.supervisor import guard_for

log = structlog.get_logger()


def start_engine(
    file: PlatformFile,
    journal: JobRecords | None = None,
    models: Library | None = None,
    catalogue: Catalogue = Catalogue(),  # noqa: B008 frozen
    data: Path | None = None,
) -> Engine:
    """An engine on the platform that the file describes; outputs are off.

    data: data folder of a daemon.  Raises ConfigError, DeviceError, DeviceDenied if another process owns the devices.
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
        return Engine(platform, file.limits, file.text, journal, models, file.self_test, named, catalogue)
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


def create_context(hardware: Hardware, data: DataFolder, catalogue: Catalogue) -> Context:
    """What the API serves; compiles the fit in the background and says so under /ready."""
    models, warm = Library(data.models), {"estimator": False}
    folders = data.recordings, data.fits, data.diagnoses, data.characterisations, data.procedures
    analyses = AnalysisJobs(JobRecords(data.jobs))
    context = Context(hardware, catalogue, analyses, *folders, models, data.calibrations, warm)
    threading.Thread(target=_warm_up, args=(context.warm,), name="warm-up", daemon=True).start()
    return context


def _warm_up(parts: dict[str, bool]) -> None:
    """Compile or load the estimator's kernels."""
    try:
        log.info("estimator_warm", seconds=round(warm_up(), 2))
        parts["estimator"] = True
    except Exception as error:  # a warm-up must never keep the daemon from serving
        log.error("warm_up_failed", error=str(error))
