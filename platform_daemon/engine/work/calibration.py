"""Calibrations as jobs: a known dipole for the receive side, a field probe for the transmit side."""

from __future__ import annotations

from pathlib import Path

from drivers.platform import Platform
from platform_daemon.schemas import CalibrationRequest
from sequences.compiler import TransmitSide

from .calibration_bench import CalibrationBench, CalibrationWork
from .receive_calibration import ReceiveCalibrationWork
from .self_test import SelfTest
from .transmit_calibration import TransmitCalibrationWork


def calibration_work(
    platform: Platform, request: CalibrationRequest, side: TransmitSide, folder: Path, self_test: SelfTest
) -> CalibrationWork:
    """The checked work of a calibration; nothing moves.  Raises ConfigError, InputError."""
    bench = CalibrationBench(platform, request, side, folder)
    return ReceiveCalibrationWork(bench) if request.kind == "receive" else TransmitCalibrationWork(bench, self_test)
