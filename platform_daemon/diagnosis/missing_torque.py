"""The torque that is missing, as a smooth function of angle and velocity, with its band of uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.arrays import Array

from .generic import Residues, monomials
from .refit import Refit

_POINTS = 25
_VISIBLE = 1e-7


@dataclass(frozen=True)
class MissingTorque:
    """Torque per inertia in rad/s^2 on a grid of angles (n,) in rad and velocities (m,) in rad/s; NaN where the motion
    never was.

    value, std: (n, m). What the declared parameters can absorb is not part of it.
    gain: fall of chi^2 over the noise factor that it would bring.
    """

    phi: Array
    phi_dot: Array
    value: Array
    std: Array
    gain: float


def missing_torque(at: Refit, left: Residues) -> MissingTorque:
    """From the scores of a smooth torque beside everything that is fitted."""
    generic, (largest, fastest) = left.torque, left.scale
    w = float(np.mean([s.dynamics.w for s in at.states]))
    norm = np.sqrt(np.maximum(np.diag(generic.information), 1e-300))
    values, vectors = np.linalg.eigh(generic.information / np.outer(norm, norm))
    visible = values > _VISIBLE * values[-1]
    inverse = (vectors[:, visible] / values[visible]) @ vectors[:, visible].T / np.outer(norm, norm)
    weights = inverse @ generic.gradient
    phi, v = np.linspace(-largest, largest, _POINTS), np.linspace(-fastest, fastest, _POINTS)
    grid_phi, grid_v = np.meshgrid(phi, v, indexing="ij")
    columns = monomials(grid_phi.ravel(), grid_v.ravel(), left.scale)
    value = (weights @ columns).reshape(grid_phi.shape) * w**2
    variance = np.einsum("kn,kl,ln->n", columns, inverse, columns).reshape(grid_phi.shape) * at.noise_factor
    outside = 1.0 - np.cos(grid_phi) + 0.5 * grid_v**2 > 1.0 - np.cos(largest)
    value[outside] = np.nan
    std = np.where(outside, np.nan, np.sqrt(np.maximum(variance, 0.0)) * w**2)
    return MissingTorque(phi, v * w, value, std, generic.gain)
