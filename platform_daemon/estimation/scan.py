"""One look at every sample: not a number, extremes, flat tops."""

from __future__ import annotations

from .jit import fast_kernel

_FLAT = 4  # samples in a run


@fast_kernel
def scan_channel(y, limit):  # type: ignore[no-untyped-def]
    """(bad, lowest, highest, sum of squares) of the samples y (n,); bad counts those that are not within +-limit."""
    bad = 0
    lowest = y[0]
    highest = y[0]
    squares = 0.0
    for i in range(y.size):
        value = y[i]
        if not abs(value) < limit:
            bad += 1
        lowest = min(lowest, value)
        highest = max(highest, value)
        squares += value * value
    return bad, lowest, highest, squares


@fast_kernel
def count_flat_runs(y, lowest, highest):  # type: ignore[no-untyped-def]
    """(runs at the highest value, at the lowest): how many runs of at least four samples sit at an extreme."""
    top = highest - 1e-9 * abs(highest)
    bottom = lowest + 1e-9 * abs(lowest)
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
