"""Clipping, seen in the samples as the converter gave them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.jit import fast_kernel, part
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.screening
_FLAT = LIMITS.flat_run_samples
_CHUNK = LIMITS.extremes_chunk_samples
_EQUAL = LIMITS.equal_share


@dataclass(frozen=True)
class Clipping:
    """Samples of a channel that pile up at its top or bottom."""

    samples: int
    channel: int
    side: str

    @property
    def severe(self) -> bool:
        """Too many for a fit to be right."""
        return self.samples >= LIMITS.clipped_samples

    def __str__(self) -> str:
        return f"{self.samples} samples of channel {self.channel} pile up at its {self.side}"


def saturation(samples: Array, quantity: str = "volts") -> str | None:
    """Why these samples are too clipped for a fit, None if they are not; samples: (channels, n), raw, in any unit.

    An encoder stays at its largest count until the swing is released. An angle is clipped only where it
    comes back to that count again.
    """
    found = find_clipping(samples)
    if found is None or not found.severe:
        return None
    y = np.asarray(samples)[found.channel]
    extreme = float(y.max() if found.side == "top" else y.min())
    return None if quantity == "angle" and peaks_at(y, extreme) < LIMITS.clipped_peaks else str(found)


def find_clipping(samples: Array) -> Clipping | None:
    """The largest pile of clipped samples, None if there is none; samples: (channels, n), raw, in any unit.

    A clipped signal piles up at its largest or smallest value: that one value occurs far more often than the next one
    below it. A smooth peak does not, neither in floating point (values hardly repeat) nor after coarse quantisation
    (the level at the top of a sine is held about as often as the next). Judge raw samples: filters and mixing of
    channels smear the pile.
    """
    found = []
    for channel, y in enumerate(np.asarray(samples)):
        for side, values in (("top", y), ("bottom", -y)):
            piled, below = _crowd(values)
            if piled >= LIMITS.piled_samples and piled > LIMITS.piled_ratio * max(below, 1):
                found.append(Clipping(piled, channel, side))
    return max(found, key=lambda clipping: clipping.samples, default=None)


def _crowd(y: Array) -> tuple[int, int]:
    """How often the largest value occurs, and how often the next smaller one."""
    if not np.isfinite(y).all() or not y.size:
        return 0, 0
    largest = float(y.max())
    rest = y[y < largest]
    if not rest.size:
        return 0, 0
    return y.size - rest.size, int(np.count_nonzero(rest == rest.max()))


def extremes(y: Array) -> tuple[float, float, int]:
    """(lowest, highest, reached) of the samples y (n,); lowest is NaN where one is not finite.

    reached: how many of every fourth sample are at one extreme, the one where there are more of them. Every run of
    four samples has such a member.
    """
    lowest, highest, reached = _extremes(y)
    return float(lowest), float(highest), int(reached)


def flat_runs(y: Array, lowest: float, highest: float) -> tuple[int, int]:
    """(runs at the highest value, at the lowest) of at least four samples of y (n,)."""
    tops, bottoms = _count_runs(y, highest - _EQUAL * abs(highest), lowest + _EQUAL * abs(lowest))
    return int(tops), int(bottoms)


def peaks_at(y: Array, extreme: float) -> int:
    """How many peaks of the samples y (n,) have four samples at the extreme; it swings back between any two peaks."""
    at = np.flatnonzero(np.abs(y - extreme) <= _EQUAL * abs(extreme))
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
    top = highest - _EQUAL * abs(highest)
    bottom = lowest + _EQUAL * abs(lowest)
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
