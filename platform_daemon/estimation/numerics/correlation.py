"""How many samples of a residual are one independent value."""

from __future__ import annotations

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from .arrays import Array


def samples_per_value(rows: Array) -> float:
    """Samples of a residual (channels, n) per independent value: 1 for white noise.

    The sum of the squares of its correlations, less the expectation of this sum for white noise.
    """
    n = int(rows.shape[1])
    size = next_fast_len(2 * n, real=True)
    power = np.abs(rfft(rows, size, axis=1)) ** 2
    lags = np.asarray(irfft(power.sum(axis=0), size), dtype=np.float64)
    squares = (lags[:n] / max(float(lags[0]), 1e-300)) ** 2
    return max(1.0, 2.0 * float(squares.sum()) - 2.0)
