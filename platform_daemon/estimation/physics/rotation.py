"""Rotations by Rodrigues vectors, with the Jacobian that turns local into global errors.

The local error of R is the body-frame rotation vector delta in R exp([delta]x).
"""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.physics

# R turned by 180 degrees about u together with phi -> -phi gives the same signal.
HALF_TURN_ABOUT_U: Array = np.diag([1.0, -1.0, -1.0])


def cross_matrix(vector: Array) -> Array:
    """[vector]x with [a]x b = a x b, (3, 3)."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation_from_rodrigues(rodrigues: Array) -> Array:
    """Rotation matrix (3, 3) about the vector's direction by its length (rad), the paper's Rodrigues formula."""
    x, y, z = rodrigues.tolist()
    theta = math.sqrt(x * x + y * y + z * z)
    # Both coefficients stay exact down to theta = 0.
    half = 0.5 * theta
    a = math.sin(theta) / theta if theta > 0.0 else 1.0
    b = 0.5 * (math.sin(half) / half) ** 2 if theta > 0.0 else 0.5
    return np.array(
        [
            [1.0 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y],
            [b * x * y + a * z, 1.0 - b * (x * x + z * z), b * y * z - a * x],
            [b * x * z - a * y, b * y * z + a * x, 1.0 - b * (x * x + y * y)],
        ]
    )


def rodrigues_from_rotation(rotation: Array) -> Array:
    """Rodrigues vector (3,) of length <= pi; goes through the unit quaternion, well conditioned everywhere."""
    (a, b, c), (d, e, f), (g, h, i) = rotation.tolist()
    # Four times the outer product of the quaternion (w, x, y, z) with itself: its row of the largest member.
    rows = (
        (1.0 + a + e + i, h - f, c - g, d - b),
        (h - f, 1.0 + a - e - i, b + d, c + g),
        (c - g, b + d, 1.0 - a + e - i, f + h),
        (d - b, c + g, f + h, 1.0 - a - e + i),
    )
    row = max(enumerate(rows), key=lambda entry: entry[1][entry[0]])[1]
    norm = math.sqrt(sum(q * q for q in row))
    w, x, y, z = (q / (norm if row[0] >= 0.0 else -norm) for q in row)
    sine = math.sqrt(x * x + y * y + z * z)
    if sine == 0.0:
        return np.zeros(3)
    return np.array([x, y, z]) * (2.0 * math.atan2(sine, w) / sine)


def rodrigues_jacobian(rodrigues: Array) -> Array:
    """d rodrigues / d delta, (3, 3): inverse right Jacobian of the rotation group."""
    x, y, z = rodrigues.tolist()
    theta = math.sqrt(x * x + y * y + z * z)
    if theta < LIMITS.small_rotation_rad:
        factor = 1.0 / 12.0 + theta**2 / 720.0
    else:
        factor = 1.0 / theta**2 - 1.0 / (2.0 * theta * math.tan(0.5 * theta))
    # 1 + [r]x / 2 + factor [r]x [r]x
    a, b, c = factor * x, factor * y, factor * z
    return np.array(
        [
            [1.0 - b * y - c * z, a * y - 0.5 * z, a * z + 0.5 * y],
            [b * x + 0.5 * z, 1.0 - a * x - c * z, b * z - 0.5 * x],
            [c * x - 0.5 * y, c * y + 0.5 * x, 1.0 - a * x - b * y],
        ]
    )


def nearest_rotation(v: Array, u: Array) -> Array:
    """Rotation with columns e_u, e_v, e_w from a trusted direction v and a less trusted u, both (3,)."""
    size = math.sqrt(v @ v)
    e_v = v / size
    across = u - (u @ e_v) * e_v
    if math.sqrt(across @ across) <= LIMITS.parallel_share * size:
        # No u-signal at all: any direction across v is as good as another.
        axis = np.eye(3)[int(np.argmin(np.abs(e_v)))]
        across = axis - (axis @ e_v) * e_v
    e_u = across / math.sqrt(across @ across)
    return np.array([e_u, e_v, cross_matrix(e_u) @ e_v]).T
