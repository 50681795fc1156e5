"""Time derivatives of sampled channels."""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.arrays import Array

# Central difference of order 8.
_STENCIL = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])


def derivative(samples: Array, rate_hz: float) -> Array:
    """Time derivative of (channels, n); the four samples at either end repeat their neighbours' value."""
    inner = np.stack([np.correlate(row, _STENCIL, mode="valid") for row in samples]) * rate_hz
    return np.pad(inner, ((0, 0), (4, 4)), mode="edge")
