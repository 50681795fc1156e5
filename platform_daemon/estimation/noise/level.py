"""How well the level of a measured noise is known: by the number of independent values that it was taken from."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.arrays import Array
from .model import BRIDGEHEAD, NoiseModel

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
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (~keep).astype(np.int8), [0]])))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        width = min(max(12, end - begin), BRIDGEHEAD)
        sides = [slice(max(0, begin - width), begin), slice(end, end + width)]
        seen = [side for side in sides if keep[side].any()] or [slice(0, keep.size)]
        for side in seen:
            out[side] += keep[side] * (end - begin) / (len(seen) * np.count_nonzero(keep[side]))
    return out
