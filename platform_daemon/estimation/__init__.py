"""Ring-down estimation: arrays in, frozen results out. Pure: no files, no devices, no web."""

from __future__ import annotations

from .calibration import CalibratedRecord, CalibrationError, calibrate
from .fit import fit_ring_down
from .noise import NoiseModel, estimate_noise
from .record import RingDownRecord
from .result import PARAMETER_NAMES, Estimate, FitResult, model_signal
from .trajectory import warm_up

__all__ = [
    "PARAMETER_NAMES",
    "CalibratedRecord",
    "CalibrationError",
    "Estimate",
    "FitResult",
    "NoiseModel",
    "RingDownRecord",
    "calibrate",
    "estimate_noise",
    "fit_ring_down",
    "model_signal",
    "warm_up",
]
