"""Ring-down estimation: arrays in, frozen results out. Pure: no files, no devices, no web.

The way of one shot through the room:
    calibration (equaliser)      volts -> dm/dt in world axes
    screening, noise, windows    is it usable, how noisy is it (welch, series_noise), which samples
    snapshot, start              start values from the first periods (spectrum, harmonics)
    growing, gauss_newton        least squares on growing windows (assemble, linear), from
    workspace, moments, sums       what the samples say, half swing by half swing, with the help of
    swing_chain                      their order in time, looked up in
    swing_table, collocation         half swings solved once for all amplitudes (chebyshev, terms)
    trajectory                   the same motion sample by sample: trace (half_swing, terms), sampling (observation)
    weighting                    every harmonic by the noise that stands there (colour)
    publish, judgement           published parameters, covariance, verdict -> result
"""

from __future__ import annotations

from .calibration import CalibratedRecord, CalibrationError, calibrate
from .fit import fit_ring_down
from .noise import NoiseModel, estimate_noise
from .record import RingDownRecord
from .result import PARAMETER_NAMES, Estimate, FitResult, model_signal
from .saturation import saturation
from .series_noise import SeriesNoise
from .warm import warm_up

__all__ = [
    "PARAMETER_NAMES",
    "CalibratedRecord",
    "CalibrationError",
    "Estimate",
    "FitResult",
    "NoiseModel",
    "RingDownRecord",
    "SeriesNoise",
    "calibrate",
    "estimate_noise",
    "fit_ring_down",
    "model_signal",
    "saturation",
    "warm_up",
]
