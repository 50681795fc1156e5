"""What is drawn, without the library that draws it, which takes longer to load than a fit to make."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class RingDownPlotData:
    """What a picture shows.

    measured and model: (c, n) in `unit`, model None if there is no fit (then there is no residual either); sampling
    rate Hz; window_s: length of the fitted window, None if there is no fit.
    """

    title: str
    caption: str
    unit: str
    channels: tuple[str, ...]
    sampling_rate_hz: float
    measured: NDArray[np.float64]
    model: NDArray[np.float64] | None
    window_s: float | None


def min_max_decimate(samples: NDArray[np.float64], points: int) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
    """Smallest and largest value per bucket, (c, buckets) each, and samples per bucket; no peak is lost."""
    size = max(1, -(-samples.shape[1] // points))
    buckets = -(-samples.shape[1] // size)
    padded = np.pad(samples, ((0, 0), (0, buckets * size - samples.shape[1])), mode="edge")
    cut = padded.reshape(samples.shape[0], buckets, size)
    return size, cut.min(axis=2), cut.max(axis=2)
