"""Ring-down estimation: arrays in, frozen results out. Pure: no files, no devices, no web.

The way of one shot through the room:
    calibration (equaliser)      volts -> dm/dt in world axes; rotation, observation: what channels see of the motion
    fit                          the whole way, from here on
    task                         what is to be fitted: a record that passed
    screening (oscillation, scan, saturation), the windows asked for (windows, periods), and its
    noise (welch, series_noise)    per channel and frequency
    snapshot, start              start values from the first periods (spectrum, line_search, harmonics, start_value)
    swings, start_angle            those of an angle: passages through zero and turning points (turning_points)
    models (terms), knowledge    what is fitted: torque terms, and what is known of the parameters beforehand (hints)
    solving                      from all starts to one minimum
    growing, gauss_newton        least squares on growing windows (assemble, linear), from
    workspace, moments, sums       what the samples say, half swing by half swing (direct_moments: one by one), with
    swing_chain, swing_walk        their order in time, looked up in
    swing_table, collocation         half swings solved once for all amplitudes of a band (swing_band, chebyshev, terms)
    trajectory                   the same motion sample by sample: trace (half_swing, tableau, terms), sampling
    weighting                    every harmonic by the noise that stands there (colour)
    disturbances (steady)        hum and drift in the residual, fitted together with the ring-down (nuisance)
    ambiguity                    did all starts lead to one minimum?
    residual, residual_trace     what is left over; leftover: with what the fit could still move (basis_table)
    companion, compression       a second oscillation in it, a receiver that compresses; misfit: whether that matters
    cause                        why no fit got through (beat)
    verdict                      good or refused
    publish, judgement, losses   published parameters (swing_state, start_label), covariance, doubts -> result, or
                                   refusal

Beside it: sliding (windows along one ring-down), derived/ (what follows from fits), bench* (speed), warm, jit and
compile_beside (compilation), threads (one per fit), arrays (types).
"""

from __future__ import annotations

from .calibration import CalibratedRecord, CalibrationError, calibrate
from .fit import fit_ring_down
from .noise import NoiseModel, estimate_noise
from .record import RingDownRecord
from .result import PARAMETER_NAMES, Estimate, FitResult, model_signal
from .saturation import find_clipping, saturation
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
    "find_clipping",
    "fit_ring_down",
    "model_signal",
    "saturation",
    "warm_up",
]
