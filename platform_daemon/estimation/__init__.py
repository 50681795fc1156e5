"""Ring-down estimation: arrays in, frozen results out. Pure: no files, no devices, no web.

The way of one shot through the room:
    calibration (equaliser)     volts -> dm/dt in world axes, a record
    fit                         the whole way, from here on
    task                        what is to be fitted: a record that passed
    signal/                       screening (oscillation, scan, saturation), windows (periods, crest); what samples tell
                                  alone: spectrum, harmonics, swings of an angle; two_lines: resonators that beat, or
                                  are far_lines
    noise/                        per channel and frequency (model, welch, colour, level: how well known), of a series,
                                  steady lines
    solving                     from all start values to one minimum
    start/                        find: start values from a snapshot of the first periods; those of an angle; value
    models, terms/                what is fitted: torques and their derivatives
    least_squares/                growing windows, gauss_newton (assemble), weighting by the noise of each harmonic;
                                  observation (rotation): how channels see the motion; knowledge beforehand; nuisance:
                                  hum and drift, fitted too; ambiguity: did all starts lead to one minimum?; publish
    passes/                       what samples say about a motion: workspace, moments (sums;
                                  direct_moments: one by one), basis_table, residual_trace
    motion/                       swing_chain, swing_walk: half swings in time, looked up in swing_table (collocation,
                                  swing_band); trajectory: the same sample by sample (trace, half_swing, tableau,
                                  sampling); swing_state, start_label, turning_points
    judging/                    residual, block_residual, floor (the noise an angle's residual shows), disturbances
                                (hum, drift), leftover: with what the fit could still move; companion (wave: its shape,
                                alongside: fitted too), compression, clipping, misfit, slow_misfit: does it matter?;
                                hints, losses, separation, twin, judgement, rivals: doubts; cause: why no fit got
                                through; verdict: good or refused
    result                      parameters with covariance and warnings, or a refusal

Each of these folders knows only those after it: judging, start, least_squares, noise, signal, passes, motion, terms,
numerics (arrays, jit: compilation, linear, chebyshev, line_search, threads: one per fit); import-linter checks it.

Beside it: sliding (windows along one ring-down), derived/ (what follows from fits), bench/ (speed), warm and
compile_beside (compilation before the first fit).
"""

from __future__ import annotations

from .calibration.apply import CalibratedRecord, calibrate
from .compilation import warm_up
from .fit import fit_ring_down
from .noise.model import NoiseModel, estimate_noise
from .noise.series import SeriesNoise
from .parameters import PARAMETER_NAMES, Estimate
from .record import RingDownRecord
from .result import FitResult, model_signal
from .screening.clipping import find_clipping, saturation
from .sensitivity import CalibrationError

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
    "find_clipping",
    "fit_ring_down",
    "model_signal",
    "saturation",
    "warm_up",
]
