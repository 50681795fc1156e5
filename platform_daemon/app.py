"""Puts the parts together: platform file -> platform -> engine -> API."""

from __future__ import annotations

import fcntl
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import structlog

from drivers.errors import ConfigError, InputError
from drivers.registry import build_platform
from platform_daemon.analysis import Library
from platform_daemon.api import Context
from platform_daemon.engine import CalibrationFiles, Engine, JobRecords, read_receive
from platform_daemon.estimation import warm_up
from platform_daemon.settings import PlatformFile, load_platform, load_sequence, load_specimen, read_toml
from platform_daemon.store import read_transmit_calibration, recover

log = structlog.get_logger()


def start_engine(file: PlatformFile, journal: JobRecords | None = None, models: Library | None = None) -> Engine:
    """An engine on the platform that the file describes; outputs are off.  Raises ConfigError, DeviceError."""
    calibration = None if file.calibration_file is None else read_receive(file.calibration_file)
    transmit = None if file.transmit_file is None else read_transmit_calibration(file.transmit_file)
    named = CalibrationFiles(file.calibration_file, file.transmit_file)
    try:
        platform = build_platform(file.section, calibration, transmit)
    except ConfigError as error:
        where = f"{file.path}: {error.where}" if error.where else str(file.path)
        raise ConfigError(error.what, where=where, why=error.why, remedy=error.remedy) from None
    try:
        return Engine(platform, file.limits, file.text, journal, models, file.self_test, named)
    except BaseException:  # Ctrl-C too
        platform.close()
        raise


@dataclass(frozen=True)
class DataFolder:
    """Where a daemon keeps what it makes; `lock` is held as long as the process lives."""

    recordings: Path
    fits: Path
    diagnoses: Path
    models: Path
    calibrations: Path
    jobs: Path
    lock: TextIO


def open_data_folder(folder: Path) -> DataFolder:
    """The folders, made if missing; series that a crash left behind are put together first.

    Raises InputError if another daemon works in this folder, OSError if it cannot be made.
    """
    names = ("recordings", "fits", "diagnoses", "models", "calibrations", "jobs")
    for name in names:
        (folder / name).mkdir(parents=True, exist_ok=True)
    lock = (folder / ".lock").open("w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        lock.close()
        remedy = "stop it, or give this one another --data folder"
        raise InputError("another daemon works in this folder", where=str(folder), remedy=remedy) from None
    made = DataFolder(**{name: folder / name for name in names}, lock=lock)
    recover(made.recordings)
    return made


def create_context(engine: Engine, data: DataFolder) -> Context:
    """What the API serves; compiles the fit in the background and says so under /ready."""
    models, warm = Library(data.models), {"estimator": False}
    context = Context(engine, data.recordings, data.fits, data.diagnoses, models, data.calibrations, warm)
    threading.Thread(target=_warm_up, args=(context.warm,), name="warm-up", daemon=True).start()
    return context


def _warm_up(parts: dict[str, bool]) -> None:
    """Compile or load the estimator's kernels."""
    try:
        log.info("estimator_warm", seconds=round(warm_up(), 2))
        parts["estimator"] = True
    except Exception as error:  # a warm-up must never keep the daemon from serving
        log.error("warm_up_failed", error=str(error))


def check_config(path: Path, endpoints: Path | None = None) -> str:
    """One sentence on a valid platform, resonator or sequence file.  Raises ConfigError, DeviceError."""
    tables, _ = read_toml(path)
    if "io_card" in tables or "limits" in tables:
        engine = start_engine(load_platform(path, endpoints=endpoints))
        status = engine.status()
        engine.close()
        return f"{path}: platform {status['platform']!r} is valid"
    if "magnets" in tables or "variant" in tables:
        return f"{path}: resonator {load_specimen(path)[0].name!r} is valid"
    if "f_tx_hz" in tables or "rx_s" in tables:
        load_sequence(path)
        return f"{path}: sequence is valid"
    remedy = "a platform has [io_card], a resonator [magnets], a sequence f_tx_hz"
    raise ConfigError("is neither a platform, a resonator nor a sequence", where=str(path), remedy=remedy)
