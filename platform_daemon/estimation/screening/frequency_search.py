"""Block means, and the frequency that explains most of a short stretch of them, with which start values begin."""

from __future__ import annotations

import math

import numpy as np
from scipy.fft import next_fast_len, rfft

from platform_daemon.estimation.numerics.arrays import Array, centred
from platform_daemon.estimation.numerics.jit import fast_kernel
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.screening


def best_frequency(data: Array, *, step_s: float, lowest: float, highest: float, weights: Array) -> float:
    """The angular frequency, rad/s, between two whose harmonics 1 and 2 explain most of data (channels, n).

    weights: (channels,) of the channels' powers.
    """
    n = data.shape[1]
    size = next_fast_len(LIMITS.frequency_search_padding * n, real=True)
    bins_per_omega = step_s * size / (2.0 * np.pi)
    first, last = math.ceil(lowest * bins_per_omega), min(int(highest * bins_per_omega), size // 4)
    spectrum = rfft(centred(data, size), axis=1)[:, first : 2 * last + 1]
    power = weights @ (spectrum.real**2 + spectrum.imag**2)
    both = power[: last + 1 - first] + power[first::2]
    k = int(both.argmax())
    if 0 < k < both.size - 1:
        left, peak, right = both[k - 1 : k + 2].tolist()
        return (first + k + 0.5 * (right - left) / (2.0 * peak - left - right)) / bins_per_omega
    return (first + k) / bins_per_omega


def block_means(y: Array, first: int, block: int, blocks: int) -> Array:
    """Means of `blocks` consecutive blocks of samples of y (channels, n) from sample `first` on, (channels, blocks)."""
    out = np.empty((y.shape[0], blocks))
    for row, means in zip(y[:, first : first + block * blocks], out, strict=True):
        _fill_means(row, block, means)
    return out


@fast_kernel
def _fill_means(y, block, out):  # type: ignore[no-untyped-def]
    """Means of blocks of y (n,) into out."""
    share = 1.0 / block
    # An index that might be negative keeps a loop from running in lanes.
    pieces = y.reshape(out.size, block)
    for k in range(out.size):
        total = 0.0
        for i in range(block):
            total += pieces[k, i]
        out[k] = share * total
