"""Normal equations of strengths, whose units differ by many powers of ten."""

from __future__ import annotations

import numpy as np

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array

_LIMITS = THRESHOLDS.regression


def solved(matrix: Array, right: Array) -> Array:
    """x (k,) or (k, n) of least norm, in units of the standard deviations, with matrix (k, k) x = right."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix * np.outer(scale, scale)
    return np.asarray(scale * np.linalg.lstsq(scaled, (scale * right.T).T, rcond=_LIMITS.information_rank)[0].T).T


def inverse(matrix: Array) -> Array:
    """Covariance (k, k) of an information matrix; what is not determined has none."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    return np.asarray(np.linalg.pinv(matrix * np.outer(scale, scale), hermitian=True) * np.outer(scale, scale))
