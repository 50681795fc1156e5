"""Ring-down estimation: arrays in, frozen results out. Pure: no files, no devices, no web.

The way of one shot through the room:
    calibration (equaliser)      volts -> dm/dt in world axes
    screening, noise, windows    is it usable, how noisy is it, which samples
    snapshot, start              start values from the first periods (spectrum, harmonics)
    growing, gauss_newton        least squares on growing windows, from moments of
    trajectory                     trace (half_swing, terms): the motion and its exact derivatives
                                   sampling: what the channels see of it (observation)
    publish, judgement           published parameters, covariance, verdict -> result
"""

from __future__ import annotations

from .calibration import CalibratedRecord, CalibrationError, calibrate
from .fit import fit_ring_down
from .noise import NoiseModel, estimate_noise
from .record import RingDownRecord
from .result import PARAMETER_NAMES, Estimate, FitResult, model_signal
from .saturation import saturation
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
    "saturation",
    "warm_up",
]
