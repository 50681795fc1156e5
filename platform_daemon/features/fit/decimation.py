"""Samples made fewer, so that a picture of them loses no peak."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def min_max_decimate(samples: NDArray[np.float64], points: int) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
    """Smallest and largest value per bucket, (c, buckets) each, and samples per bucket; no peak is lost."""
    size = max(1, -(-samples.shape[1] // points))
    buckets = -(-samples.shape[1] // size)
    padded = np.pad(samples, ((0, 0), (0, buckets * size - samples.shape[1])), mode="edge")
    cut = padded.reshape(samples.shape[0], buckets, size)
    return size, cut.min(axis=2), cut.max(axis=2)
