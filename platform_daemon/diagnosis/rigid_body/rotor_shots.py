"""Shots as the fit of the rigid rotor takes them, with start values from one angle."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.shots.shot import DiagnosisShot, SampleGrid, band_sd, even_grid
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory
from platform_daemon.estimation.record import RingDownRecord
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
        rotation = known.facing(observed.rotation)
        values = RotorValues(
            f_nat_hz=f_nat_hz,
            m_r_am2=m_r_am2,
            distance_m=known.geometry.distance_m(f_nat_hz, m_r_am2),
            lambda_per_s=float(np.clip(loss, *_LIMITS.damping_per_s)),
            rotation=rotation,
            tf_over_i_rad_per_s2=coefficients.get("tf_over_i_rad_per_s2", 0.0) if jewel else 0.0,
            friction_coefficient=known.geometry.friction_coefficient,
            side_damping_per_s=_LIMITS.side_damping_per_s,
            lean_damping_per_s=_LIMITS.side_damping_per_s,
            damping_axis_to_thread=0.0 if jewel else _LIMITS.damping_axis_to_thread,
            creep_m_per_s=_LIMITS.creep_m_per_s if jewel else 0.0,
            creep_spin_rad_per_s=_LIMITS.creep_spin_rad_per_s if jewel else 0.0,
        )
        # The friction of a jewel's contact, which slips and sticks, has harmonics beyond any filter, and where no drive
        # is known the motion begins with the first sample.
        every = jewel or known.drive is None
        grid = SampleGrid.every_sample(record) if every else even_grid(record, f_nat_hz)
        first, rate_hz = grid.first * grid.factor, record.sampling_rate_hz / grid.factor
        if known.drive is None:
            side = -1.0 if known.turned(observed.rotation) else 1.0
            phi, speed = _first_state(base.hypothesis.model, state.dynamics, record)
            values = replace(values, start_angle_rad=side * phi, start_speed_rad_per_s=side * speed)
        shots.append(
            RotorShot(
                samples=_swinging(grid.of(record.samples), rate_hz, f_nat_hz),
                rate_hz=rate_hz,
                sd=_sd_of(shot, grid, f_nat_hz),
                geometry=known.geometry,
                drive=known.drive_from(first * record.dt_s),
                values=values,
                declared=_upright(rotation) if known.rotation is None else known.rotation,
                start=known.start,
                noise_share=grid.dof / grid.count,
            )
        )
    return shots


def _first_state(model: RingDownModel, motion: MotionParameters, record: RingDownRecord) -> tuple[float, float]:
    """Angle, rad, and speed, rad/s, of one angle at the first valid sample."""
    first, dt_s = record.valid_from, record.dt_s
    phi, per_turn = Trajectory(model, motion, (first + 1) * dt_s).basis(first, first + 1, dt_s, STATE)[:2, 0].tolist()
    return phi, per_turn * motion.w


def _sd_of(shot: DiagnosisShot, grid: SampleGrid, frequency_hz: float) -> Array:
    """Of white noise with the density that the samples of a grid have; frequency_hz: of the swing."""
    if grid.factor == 1:
        return shot.noise.sd
    return np.asarray(band_sd(shot.noise, frequency_hz, shot.rate_hz) / math.sqrt(grid.factor))


def _upright(rotation: Array) -> Array:
    """The orientation with a vertical main axis, where it is nearly so: one angle is wrong by as much for an error."""
    axis = rotation[:, 2]
    tilt = math.acos(float(np.clip(axis[2], -1.0, 1.0)))
    if not 0.0 < tilt < _LIMITS.upright_rad:
        return rotation
    across = np.array([axis[1], -axis[0], 0.0]) / math.hypot(axis[0], axis[1])
    return np.asarray(rotation_from_rodrigues(tilt * across) @ rotation)


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
