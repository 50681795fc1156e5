"""The inverse of a sensitivity P, u = -P dm/dt (eq:u(t,p,R))."""

from __future__ import annotations

import numpy as np

from .numerics.arrays import Array
from .thresholds import THRESHOLDS

LIMITS = THRESHOLDS.calibration


class CalibrationError(ValueError):
    """A calibration that cannot be applied: says which item, and what was expected."""


def real_array(values: Array, name: str) -> Array:
    """As float64.  Raises CalibrationError for complex values, of which numpy would drop a part."""
    if np.iscomplexobj(values):
        raise CalibrationError(f"{name} must be real, not complex")
    return np.asarray(values, dtype=np.float64)


def inverse_sensitivity(sensitivity: Array, channels: int) -> Array:
    """Pseudo-inverse (3, channels) of P (channels, 3).

    Raises:
        CalibrationError: wrong shape, NaN, fewer than three independent rows.
    """
    p = real_array(sensitivity, "sensitivity")
    if p.shape != (channels, 3):
        raise CalibrationError(f"sensitivity must have shape ({channels}, 3), not {p.shape}")
    if not np.all(np.isfinite(p)):
        raise CalibrationError("sensitivity contains NaN or infinity")
    singular = np.linalg.svd(p, compute_uv=False)
    if singular.size < 3 or singular[2] <= singular[0] / LIMITS.largest_condition:
        raise CalibrationError(
            "sensitivity is singular: its rows do not span the three world axes (singular values "
            + ", ".join(f"{s:.3g}" for s in singular)
            + " T/A)"
        )
    return np.asarray(np.linalg.pinv(p))
