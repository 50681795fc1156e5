"""How much of a stretch harmonics 1 and 2 of a trial frequency explain: the search that start values begin with."""

from __future__ import annotations

import math

import numpy as np

from .jit import fast_kernel, fast_part
from .linear import factorise, substitute


@fast_part
def _dot(a, b):  # type: ignore[no-untyped-def]
    """Scalar product."""
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


@fast_part
def explained_power(data, step, omega, weights):  # type: ignore[no-untyped-def]
    """Weighted power of data (channels, n) that cos, sin of omega t and 2 omega t explain, t = i step."""
    n = data.shape[1]
    channels = data.shape[0]
    gram = np.zeros((4, 4))
    sums = np.zeros((channels, 4))
    order = np.empty(4, dtype=np.int64)
    waves = np.empty((4, n))
    x = np.empty(4)
    turn_c = math.cos(omega * step)
    turn_s = math.sin(omega * step)
    c = 1.0
    s = 0.0
    for i in range(n):
        waves[0, i] = c
        waves[1, i] = s
        waves[2, i] = c * c - s * s
        waves[3, i] = 2.0 * c * s
        c, s = c * turn_c - s * turn_s, s * turn_c + c * turn_s
    for j in range(4):
        for k in range(j + 1):
            gram[j, k] = _dot(waves[j], waves[k])
            gram[k, j] = gram[j, k]
        for channel in range(channels):
            sums[channel, j] = _dot(waves[j], data[channel])
    if not factorise(gram, order):
        return 0.0
    power = 0.0
    for channel in range(channels):
        for j in range(4):
            x[j] = sums[channel, j]
        substitute(gram, order, x)
        for j in range(4):
            power += weights[channel] * x[j] * sums[channel, j]
    return power


@fast_kernel
def best_frequency(data, step, lowest, highest, trials, weights):  # type: ignore[no-untyped-def]
    """The angular frequency among evenly spaced trials that explains most."""
    best = lowest
    most = -1.0
    for k in range(trials):
        omega = lowest + (highest - lowest) * k / (trials - 1)
        power = explained_power(data, step, omega, weights)
        if power > most:
            most = power
            best = omega
    return best


@fast_kernel
def block_means(y, first, block, blocks, out):  # type: ignore[no-untyped-def]
    """Means of consecutive blocks of samples of y (channels, n) into out (channels, blocks)."""
    for channel in range(y.shape[0]):
        for k in range(blocks):
            total = 0.0
            for i in range(first + k * block, first + (k + 1) * block):
                total += y[channel, i]
            out[channel, k] = total / block
