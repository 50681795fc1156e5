"""The extremes of a channel, and flat tops: runs of samples there."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.arrays import Array
from ..numerics.jit import fast_kernel, part

_FLAT = 4  # samples in a run
_CHUNK = 512  # samples that are still at hand when they are looked at again


def extremes(y: Array) -> tuple[float, float, int]:
    """(lowest, highest, reached) of the samples y (n,); lowest is NaN where one is not finite.

    reached: how many of every fourth sample are at one extreme, the one where there are more of them. Every run of
    four samples has such a member.
    """
    lowest, highest, reached = _extremes(y)
    return float(lowest), float(highest), int(reached)


def flat_runs(y: Array, lowest: float, highest: float) -> tuple[int, int]:
    """(runs at the highest value, at the lowest) of at least four samples of y (n,)."""
    tops, bottoms = _count_runs(y, highest - 1e-9 * abs(highest), lowest + 1e-9 * abs(lowest))
    return int(tops), int(bottoms)


def peaks_at(y: Array, extreme: float) -> int:
    """How many peaks of the samples y (n,) have four samples at the extreme; it swings back between any two peaks."""
    at = np.flatnonzero(np.abs(y - extreme) <= 1e-9 * abs(extreme))
    middle = 0.5 * (float(y.min()) + float(y.max()))
    back = np.cumsum((y > middle) != (extreme > middle))[at]
    return int(np.count_nonzero(np.unique(back, return_counts=True)[1] >= _FLAT))


@fast_kernel
def _extremes(y):  # type: ignore[no-untyped-def]
    """What `extremes` returns. Chunks that do not reach the extremes are looked at once only."""
    n = y.size
    chunks = np.empty(((n + _CHUNK - 1) // _CHUNK, 2))
    total = 0.0
    lowest = highest = y[0]
    for k in range(chunks.shape[0]):
        chunk = y[k * _CHUNK : min(n, (k + 1) * _CHUNK)]
        low = high = chunk[0]
        for i in range(chunk.size):
            low = min(low, chunk[i])
            high = max(high, chunk[i])
            total += chunk[i]
        chunks[k, 0] = low
        chunks[k, 1] = high
        lowest = min(lowest, low)
        highest = max(highest, high)
    top = highest - 1e-9 * abs(highest)
    bottom = lowest + 1e-9 * abs(lowest)
    tops = 0
    bottoms = 0
    for k in range(chunks.shape[0]):
        if chunks[k, 0] <= bottom or chunks[k, 1] >= top:
            tops, bottoms = _add_reached(y[k * _CHUNK : min(n, (k + 1) * _CHUNK)], top, bottom, tops, bottoms)
    return lowest if math.isfinite(total) else np.nan, highest, max(tops, bottoms)


@part
def _add_reached(y, top, bottom, tops, bottoms):  # type: ignore[no-untyped-def]
    """How many of every fourth sample reach `top`, how many `bottom`, added to those before."""
    for i in range(0, y.size, _FLAT):
        if y[i] >= top:
            tops += 1
        if y[i] <= bottom:
            bottoms += 1
    return tops, bottoms


@fast_kernel
def _count_runs(y, top, bottom):  # type: ignore[no-untyped-def]
    """How many runs reach `top`, how many `bottom`."""
    tops = 0
    bottoms = 0
    high = 0
    low = 0
    for i in range(y.size):
        value = y[i]
        if value >= top:
            high += 1
            if high == _FLAT:
                tops += 1
        else:
            high = 0
        if value <= bottom:
            low += 1
            if low == _FLAT:
                bottoms += 1
        else:
            low = 0
    return tops, bottoms
