"""How well the level of a measured noise is known: by the number of independent values that it was taken from."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.arrays import Array
from .model import NoiseModel, gaps

_MEDIAN = 0.5 * math.pi  # variance of a median over that of a mean


def level_sd(noise: NoiseModel) -> float:
    """Relative standard deviation of a channel's noise power, were it white; 0 for noise that is known."""
    if noise.degrees is None:
        return 0.0
    keep = noise.degrees > 0.0
    if not keep.any():
        return math.inf
    weights = keep + math.sqrt(_MEDIAN) * _lent(keep)
    variance = noise.correlated_bins * float(np.sum(weights[keep] ** 2 / noise.degrees[keep]))
    return math.sqrt(variance) / keep.size


def _lent(keep: np.ndarray) -> Array:
    """By how many bins of gaps every bin stands for them as well, as `bridge` fills them from both sides."""
    out = np.zeros(keep.size)
    for begin, end, seen in gaps(keep):
        for side in seen:
            out[side] += keep[side] * (end - begin) / (len(seen) * np.count_nonzero(keep[side]))
    return out
