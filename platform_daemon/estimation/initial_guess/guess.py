"""Start values from the data alone: frequency, amplitude, phase, orientation and loss from one snapshot."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.observation_model import (
    DipoleObservation,
    FreeGainObservation,
    Observation,
)
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.orbit import (
    amplitude_from_second_harmonic,
    amplitude_from_third_harmonic,
    first_harmonic,
    frequency_ratio,
)
from platform_daemon.estimation.physics.rotation import nearest_rotation
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.sensitivity import inverse_sensitivity
from platform_daemon.estimation.thresholds import THRESHOLDS

from .angle import guess_initial_state_of_angle
from .harmonic_fit import HarmonicFit, fit_harmonics
from .initial_state import InitialState

LIMITS = THRESHOLDS.start_values


def observes_dipole(record: RingDownRecord, model: RingDownModel) -> bool:
    """True if the channels are tied by m_r and R: they are dm/dt, or volts of known sensitivity."""
    known = record.quantity == "dmdt" or record.sensitivity is not None
    return known and model.observation == "by_quantity"


def guess_initial_state(
    record: RingDownRecord, model: RingDownModel, *, first: int, last: int, frequency_hz: float, noise_sd: Array
) -> InitialState:
    """Start values from the first ten periods, or more where noise hides the weak harmonics."""
    if record.quantity == "angle":
        return guess_initial_state_of_angle(record, model, first=first, last=last, frequency_hz=frequency_hz)
    dipole = observes_dipole(record, model)
    periods = LIMITS.first_periods
    while True:
        stop = min(last, first + math.ceil(periods / (frequency_hz * record.dt_s)))
        snapshot = fit_harmonics(
            record.samples, first=first, last=stop, dt_s=record.dt_s, frequency_hz=frequency_hz, noise_sd=noise_sd
        )
        if record.sensitivity is not None and dipole:
            snapshot = _calibrated(snapshot, record.sensitivity)
        waves = _aligned(snapshot)
        snr = waves.snr_second if dipole else waves.snr_third
        if snr > LIMITS.trusted_snr or stop >= last or periods >= LIMITS.most_stretches * LIMITS.first_periods:
            break
        periods *= 2
    amplitudes = _amplitudes(dipole, waves, snr)
    seen = (stop - first) * record.dt_s * snapshot.omega / (2.0 * math.pi)
    return InitialState(amplitudes, seen, cache(partial(_state, record, model, snapshot, waves)))


def _calibrated(snapshot: HarmonicFit, sensitivity: Array) -> HarmonicFit:
    """The snapshot of the world's dm/dt that volts of this sensitivity (channels, 3) show."""
    inverse = -inverse_sensitivity(sensitivity, snapshot.z.shape[1])
    return replace(snapshot, z=snapshot.z @ inverse.T, z_sd=np.sqrt(inverse**2 @ snapshot.z_sd**2))


@dataclass(frozen=True)
class _Waves:
    """Real channel vectors of the harmonics once the phase is known: v (1st), u (2nd), third."""

    phase: float
    v: Array
    u: Array
    third: float
    snr_second: float
    snr_third: float


def _aligned(snapshot: HarmonicFit) -> _Waves:
    """Common phase of the fundamental, then all harmonics as real vectors along their known phases.

    With phase Theta since the turning point +A: v-signal -sin(Theta), u-signal +sin(2 Theta), third -sin(3 Theta).
    """
    weight = snapshot.z_sd**-2.0
    z1, z2, z3 = snapshot.z[0], snapshot.z[1], snapshot.z[2]
    common = 0.5 * cmath.phase(weight @ (z1 * z1))
    v = (z1 * cmath.exp(-1j * common)).real
    if v[np.abs(v).argmax()] < 0.0:
        common += math.pi
        v = -v
    theta = common - 0.5 * math.pi
    u = (z2 * (1j * cmath.exp(-2j * theta))).real
    weighted = weight * v
    square = float(weighted @ v)
    third = float(weighted @ (z3 * (-1j * cmath.exp(-3j * theta))).real) / square
    return _Waves(
        phase=theta,
        v=v,
        u=u,
        third=third,
        snr_second=math.sqrt(weight @ (u * u)),
        snr_third=abs(third) * math.sqrt(square),
    )


def _amplitudes(dipole: bool, waves: _Waves, snr: float) -> tuple[float, ...]:
    """Candidate amplitudes: u/v ratio for calibrated dm/dt, third harmonic where gains are unknown."""
    if dipole:
        ratio = math.sqrt((waves.u @ waves.u) / (waves.v @ waves.v))
        best = amplitude_from_second_harmonic(ratio)
        found: tuple[float, ...] = (best, *(factor * best for factor in LIMITS.dipole_other_amplitudes))
        found += (LIMITS.small_amplitude_rad,) if best < LIMITS.small_amplitude_rad else ()
    elif snr > LIMITS.trusted_snr and waves.third > 0.0:
        best = amplitude_from_third_harmonic(waves.third)
        found = (best, *(factor * best for factor in LIMITS.free_gain_other_amplitudes))
    else:
        found = LIMITS.blind_amplitudes_rad
    return tuple(min(max(a, LIMITS.amplitude_range_rad[0]), LIMITS.amplitude_range_rad[1]) for a in found)


def _state(
    record: RingDownRecord, model: RingDownModel, snapshot: HarmonicFit, waves: _Waves, amplitude: float
) -> FitState:
    """A fit state from the snapshot with this amplitude in its middle."""
    ratio, time_s, decay = frequency_ratio(amplitude), snapshot.time_s, max(snapshot.decay_per_s, 0.0)
    w = snapshot.omega / ratio
    growth = math.exp(min(decay * time_s, LIMITS.most_decay))
    # The frequency has risen to that of the middle as the amplitude fell.
    rise = max(snapshot.omega - w * frequency_ratio(min(amplitude * growth, LIMITS.widest_rad)), 0.0)
    phase = (waves.phase - (snapshot.omega - 0.5 * rise) * time_s) % (2.0 * math.pi)
    # Anchor at the turning point a quarter to three quarters of a period before t = 0.
    start = amplitude * growth
    if phase < 0.5 * math.pi:
        anchor, phase = -start, phase + math.pi
    elif phase > 1.5 * math.pi:
        anchor, phase = -start, phase - math.pi
    else:
        anchor = start
    dynamics = MotionParameters(
        w=w,
        theta=phase * w / (snapshot.omega - rise),
        amplitude=anchor,
        values=_losses(model, snapshot.decay_per_s, w, amplitude),
    )
    v1 = first_harmonic(amplitude) * w
    return FitState(dynamics, _observation(record, model, waves, v1, amplitude), np.zeros(record.channels))


def _losses(model: RingDownModel, decay_per_s: float, w: float, amplitude: float) -> tuple[float, ...]:
    """Share the observed decay: typical values for all losses but the last, the rest for the last one; others are 0."""
    values = {c.name: c.typical * w**c.power for c in model.coefficients}
    for c in model.coefficients:
        if c.name not in model.losses and not c.hidden:
            values[c.name] = 0.0
    if model.losses:
        *others, last = model.losses
        powers = {c.name: c.power for c in model.coefficients}
        power = powers[last]
        rest = max(decay_per_s - sum(values[name] for name in others if powers[name] == 1), 0.0)
        # Friction makes the amplitude fall in a straight line. Of any other power the size alone is known.
        shares = {1: 1.0, 2: 0.5 * math.pi * amplitude * w, 0: 1.0 / (amplitude * w)}
        rest *= shares.get(power, w ** (power - 1))
        values[last] = max(rest, LIMITS.least_loss_share * values[last])
    return tuple(values[c.name] for c in model.coefficients)


def _observation(
    record: RingDownRecord, model: RingDownModel, waves: _Waves, v1: float, amplitude: float
) -> Observation:
    """Orientation and moment, or free gains, from the real harmonic vectors."""
    if observes_dipole(record, model):
        rotation = nearest_rotation(waves.v, waves.u)
        mixing = np.eye(3) if record.sensitivity is None else -np.asarray(record.sensitivity, dtype=np.float64)
        return DipoleObservation(math.sqrt(waves.v @ waves.v) / v1, rotation, mixing)
    ratio = 2.0 * math.tan(0.25 * amplitude)
    sign = 1.0 if record.quantity == "dmdt" else -1.0
    return FreeGainObservation(np.column_stack([waves.v, waves.u / ratio]) / v1, sign)
