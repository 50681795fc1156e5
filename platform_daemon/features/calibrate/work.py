"""Calibrations as jobs: a known dipole for the receive side, a field probe for the transmit side."""

from __future__ import annotations

from pathlib import Path

from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.schemas.requests import CalibrationRequest
from platform_daemon.core.service.bench import HardwareBench
from platform_daemon.core.state.disk_space import check_free_space

from .calibration_bench import CalibrationBench, CalibrationWork
from .receive_calibration import ReceiveCalibrationWork
from .transmit_calibration import TransmitCalibrationWork


def plan_calibration(engine: Engine, request: CalibrationRequest, folder: Path) -> CalibrationWork:
    """The checked work of a calibration, which writes a new version into `folder`; nothing moves.

    Raises ConfigError, InputError.
    """
    bench = CalibrationBench(engine.platform, request, engine.side, folder)
    if request.kind == "receive":
        return ReceiveCalibrationWork(bench)
    return TransmitCalibrationWork(bench, engine.calibration_in_use.chain_test)


def plan(bench: HardwareBench, request: CalibrationRequest) -> CalibrationWork:
    """See plan_calibration.  Raises also StorageUnusable."""
    if bench.again is None:
        check_free_space(bench.folders.calibrations, 0)  # a file of some kB: what it costs is the shots before it
    return plan_calibration(bench.engine, request, bench.folders.calibrations)
