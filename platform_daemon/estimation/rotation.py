"""Rotations by Rodrigues vectors, with the Jacobian that turns local into global errors.

The local error of R is the body-frame rotation vector delta in R exp([delta]x).
"""

from __future__ import annotations

import numpy as np

from .arrays import Array

# R turned by 180 degrees about u together with phi -> -phi gives the same signal.
HALF_TURN_ABOUT_U: Array = np.diag([1.0, -1.0, -1.0])


def cross_matrix(vector: Array) -> Array:
    """[vector]x with [a]x b = a x b, (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_from_rodrigues(rodrigues: Array) -> Array:
    """Rotation matrix (3, 3) about the vector's direction by its length (rad), the paper's Rodrigues formula."""
    theta = float(np.linalg.norm(rodrigues))
    k = cross_matrix(np.asarray(rodrigues, dtype=np.float64))
    # sinc keeps both coefficients exact down to theta = 0.
    return np.asarray(np.eye(3) + np.sinc(theta / np.pi) * k + 0.5 * np.sinc(theta / (2.0 * np.pi)) ** 2 * (k @ k))


def rodrigues_from_rotation(rotation: Array) -> Array:
    """Rodrigues vector (3,) of length <= pi; goes through the unit quaternion, well conditioned everywhere."""
    r = rotation
    # Four times the outer product of the quaternion (w, x, y, z) with itself.
    outer = np.array(
        [
            [1 + r[0, 0] + r[1, 1] + r[2, 2], r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], 1 + r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], 1 - r[0, 0] + r[1, 1] - r[2, 2], r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 1 - r[0, 0] - r[1, 1] + r[2, 2]],
        ]
    )
    quaternion = outer[int(np.argmax(np.diag(outer)))]
    quaternion = quaternion / np.linalg.norm(quaternion)
    if quaternion[0] < 0.0:
        quaternion = -quaternion
    axis = quaternion[1:]
    sine = float(np.linalg.norm(axis))
    if sine == 0.0:
        return np.zeros(3)
    return np.asarray(axis * (2.0 * np.arctan2(sine, quaternion[0]) / sine))


def rodrigues_jacobian(rodrigues: Array) -> Array:
    """d rodrigues / d delta, (3, 3): inverse right Jacobian of the rotation group."""
    theta = float(np.linalg.norm(rodrigues))
    k = cross_matrix(rodrigues)
    if theta < 1e-4:
        factor = 1.0 / 12.0 + theta**2 / 720.0
    else:
        factor = 1.0 / theta**2 - 1.0 / (2.0 * theta * np.tan(0.5 * theta))
    return np.asarray(np.eye(3) + 0.5 * k + factor * (k @ k))


def nearest_rotation(v: Array, u: Array) -> Array:
    """Rotation with columns e_u, e_v, e_w from a trusted direction v and a less trusted u, both (3,)."""
    e_v = v / np.linalg.norm(v)
    across = u - (u @ e_v) * e_v
    if np.linalg.norm(across) <= 1e-9 * np.linalg.norm(v):
        # No u-signal at all: any direction across v is as good as another.
        axis = np.eye(3)[int(np.argmin(np.abs(e_v)))]
        across = axis - (axis @ e_v) * e_v
    e_u = across / np.linalg.norm(across)
    return np.column_stack([e_u, e_v, np.cross(e_u, e_v)])
