"""Array types used throughout: float64 unless a docstring says otherwise."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.physics

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
ComplexArray = NDArray[np.complex128]


def grown(value: float, step: float) -> float:
    """A value other than 0 after a step that multiplies it; never of the other sign, at most twentyfold."""
    return value * math.exp(min(max(step / value, -LIMITS.most_log_growth), LIMITS.most_log_growth))


def medians(values: Array) -> Array:
    """Medians along the last axis; numpy's own takes longer than the sorting, for checks that are not needed here."""
    n = values.shape[-1]
    half = n // 2
    if n % 2 == 1:
        return np.asarray(np.partition(values, half, axis=-1)[..., half])
    ordered = np.partition(values, (half - 1, half), axis=-1)
    return np.asarray(0.5 * (ordered[..., half - 1] + ordered[..., half]))


def centred(rows: Array, size: int) -> Array:
    """Rows (k, n) without their means, then zeros, (k, size): scipy's own padding takes longer than the transform."""
    n = rows.shape[1]
    out = np.zeros((rows.shape[0], size))
    np.subtract(rows, (rows.sum(axis=1) / n)[:, None], out=out[:, :n])
    return out
