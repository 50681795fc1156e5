"""The torque that is missing, as a smooth function of angle and velocity, with its band of uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.selection.omnibus_test import OmnibusTest, monomials
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

_LIMITS = THRESHOLDS.findings


@dataclass(frozen=True, kw_only=True)
class MissingTorque:
    """Torque per inertia in rad/s^2 on a grid of angles (n,) in rad and velocities (m,) in rad/s; NaN where the motion
    never was, and where the declared parameters absorb all that acts there.

    value, std: (n, m). What the declared parameters can absorb is not part of it.
    gain: fall of chi^2 over the noise factor that it would bring.
    """

    phi: Array
    phi_dot: Array
    value: Array
    std: Array
    gain: float


def missing_torque(at: JointFit, left: OmnibusTest) -> MissingTorque | None:
    """From the scores of a smooth torque, all fitted parameters eliminated; None if these absorb any torque."""
    generic, (largest, fastest) = left.torque, left.scale
    w = float(np.mean([s.dynamics.w for s in at.states]))
    determined = np.diag(generic.information) > _LIMITS.map_beside * generic.power
    if not determined.any():
        return None
    information = np.where(np.outer(determined, determined), generic.information, 0.0)
    norm = np.sqrt(np.where(determined, np.diag(information), 1.0))
    values, vectors = np.linalg.eigh(information / np.outer(norm, norm))
    visible = values > _LIMITS.map_share * values[-1]
    inverse = (vectors[:, visible] / values[visible]) @ vectors[:, visible].T / np.outer(norm, norm)
    weights = inverse @ generic.gradient
    phi, v = np.linspace(-largest, largest, _LIMITS.map_points), np.linspace(-fastest, fastest, _LIMITS.map_points)
    grid_phi, grid_v = np.meshgrid(phi, v, indexing="ij")
    columns = monomials(grid_phi.ravel(), grid_v.ravel(), left.scale)
    value = (weights @ columns).reshape(grid_phi.shape) * w**2
    variance = np.einsum("kn,kl,ln->n", columns, inverse, columns).reshape(grid_phi.shape) * at.noise_factor
    outside = 1.0 - np.cos(grid_phi) + 0.5 * grid_v**2 > 1.0 - np.cos(largest)
    undetermined = outside | (
        variance <= _LIMITS.map_rounding * variance[~outside].max()
    )  # 0 +- 0 would say that there is none
    value[undetermined] = np.nan
    std = np.where(undetermined, np.nan, np.sqrt(np.maximum(variance, 0.0)) * w**2)
    return MissingTorque(phi=phi, phi_dot=v * w, value=value, std=std, gain=generic.gain)
