"""Flat tops: runs of samples at a channel's extreme."""

from __future__ import annotations

import numpy as np

from .arrays import Array
from .jit import fast_kernel

_FLAT = 4  # samples in a run


def flat_runs(y: Array, lowest: float, highest: float, fewest: int) -> tuple[int, int]:
    """(runs at the highest value, at the lowest) of at least four samples of y (n,); (0, 0) if surely below `fewest`.

    Every run has a member among every fourth sample, so those few tell nearly always.
    """
    top, bottom = highest - 1e-9 * abs(highest), lowest + 1e-9 * abs(lowest)
    some = y[::_FLAT]
    if max(np.count_nonzero(some >= top), np.count_nonzero(some <= bottom)) < fewest:
        return 0, 0
    tops, bottoms = _count_runs(y, top, bottom)
    return int(tops), int(bottoms)


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
