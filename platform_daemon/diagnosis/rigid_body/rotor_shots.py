"""Shots as the fit of the rigid rotor takes them, with start values from one angle."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.rotor_fit.shot import RotorShot

_LIMITS = THRESHOLDS.rigid_body


def rotor_shots(base: JointFit) -> list[RotorShot]:
    """Shots with start values from one angle; none if a shot's drive or geometry is not known."""
    shots = []
    for prepared, state in zip(base.prepared, base.states, strict=True):
        known, observed, shot = prepared.shot.rotor, state.observation, prepared.shot
        if known is None or not isinstance(observed, DipoleObservation):
            return []
        coefficients = dict(
            zip((c.name for c in base.hypothesis.model.coefficients), state.dynamics.values, strict=True)
        )
        record, jewel = shot.record, known.geometry.bearing == "jewel"
        loss = coefficients.get("lambda_per_s", 0.0)
        f_nat_hz, m_r_am2 = state.dynamics.w / (2.0 * math.pi), abs(observed.m_r)
        values = RotorValues(
            f_nat_hz=f_nat_hz,
            m_r_am2=m_r_am2,
            distance_m=known.geometry.distance_m(f_nat_hz, m_r_am2),
            lambda_per_s=float(np.clip(loss, *_LIMITS.damping_per_s)),
            rotation=known.facing(observed.rotation),
            tf_over_i_rad_per_s2=coefficients.get("tf_over_i_rad_per_s2", 0.0) if jewel else 0.0,
            friction_coefficient=known.geometry.friction_coefficient,
            side_damping_per_s=_LIMITS.side_damping_per_s,
            creep_m_per_s=_LIMITS.creep_m_per_s if jewel else 0.0,
        )
        late_s = record.valid_from / record.sampling_rate_hz
        shots.append(
            RotorShot(
                samples=_swinging(record.valid, record.sampling_rate_hz, f_nat_hz),
                rate_hz=record.sampling_rate_hz,
                sd=shot.noise.sd,
                geometry=known.geometry,
                drive=replace(known.drive, rx_start_s=known.drive.rx_start_s + late_s),
                values=values,
                declared=known.rotation,
                moving=known.moving,
            )
        )
    return shots


def _swinging(samples: Array, rate_hz: float, frequency_hz: float) -> Array:
    """The samples until the swing has become small."""
    stretch = max(1, round(_LIMITS.swing_periods * rate_hz / frequency_hz))
    count = samples.shape[1] // stretch
    if count < 2:
        return samples
    turns = np.exp(-2.0j * np.pi * frequency_hz / rate_hz * np.arange(count * stretch)).reshape(count, stretch)
    parts = samples[:, : count * stretch].reshape(-1, count, stretch)
    sizes = np.linalg.norm((parts * turns).mean(axis=2), axis=0)
    large = np.flatnonzero(sizes > _LIMITS.kept_swing * sizes.max())
    return samples if large[-1] == count - 1 else samples[:, : (large[-1] + 1) * stretch]
