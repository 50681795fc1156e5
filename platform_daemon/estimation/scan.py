"""The extremes of a channel, and flat tops: runs of samples there."""

from __future__ import annotations

import math

import numpy as np

from .arrays import Array
from .jit import fast_kernel

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


@fast_kernel
def _extremes(y):  # type: ignore[no-untyped-def]
    """What `extremes` returns. Chunks that do not reach the extremes are looked at once only."""
    n = y.size
    lows = np.empty((n + _CHUNK - 1) // _CHUNK)
    highs = np.empty(lows.size)
    total = 0.0
    for k in range(lows.size):
        chunk = y[k * _CHUNK : min(n, (k + 1) * _CHUNK)]
        low = high = chunk[0]
        for i in range(chunk.size):
            low = min(low, chunk[i])
            high = max(high, chunk[i])
            total += chunk[i]
        lows[k] = low
        highs[k] = high
    low = lows.min()
    high = highs.max()
    tops = 0
    bottoms = 0
    for k in range(lows.size):
        if highs[k] >= high - 1e-9 * abs(high) or lows[k] <= low + 1e-9 * abs(low):
            for i in range(k * _CHUNK, min(n, (k + 1) * _CHUNK), _FLAT):
                tops += y[i] >= high - 1e-9 * abs(high)
                bottoms += y[i] <= low + 1e-9 * abs(low)
    return low if math.isfinite(total) else np.nan, high, max(tops, bottoms)


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
