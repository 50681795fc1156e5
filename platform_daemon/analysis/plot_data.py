"""What is drawn, without the library that draws it, which takes longer to load than a fit to make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from platform_daemon.estimation import FitResult, model_signal
from platform_daemon.schemas import Window

from .fit import fit_signal
from .fit_request import FitRequest
from .measurement import VoltageMeasurement
from .model_registry.resolve import ModelChoice


@dataclass(frozen=True)
class RingDownPlotData:
    """What a picture shows.

    measured and model: (c, n) in `unit`, model None if the fit was refused (then there is no residual either);
    sampling rate Hz.
    """

    title: str
    fit: FitResult
    unit: str
    channels: tuple[str, ...]
    sampling_rate_hz: float
    measured: NDArray[np.float64]
    model: NDArray[np.float64] | None


def ring_down_plot_data(
    measurement: VoltageMeasurement, frame: int, model: ModelChoice | None, window: Window, terms: Sequence[str] = ()
) -> RingDownPlotData:
    """What to draw of one frame: its calibrated signal with the fit over it, or without if the fit was refused."""
    used, chosen = measurement.under(model, terms)
    signal = used.signal(frame)
    measured, rate_hz = signal.record.samples, signal.record.sampling_rate_hz
    fit = fit_signal(signal, FitRequest(chosen, window), used.noise())
    calibrated, provenance = used.calibration is not None, measurement.recording.provenance
    names = provenance.channel_names if provenance else ()
    return RingDownPlotData(
        title=f"{used.path.name}, frame {frame}",
        fit=fit,
        unit="dm/dt / A m² s⁻¹" if calibrated else "ADC input / V",
        channels=tuple("xyz") if calibrated else names or tuple(map(str, range(measured.shape[0]))),
        sampling_rate_hz=rate_hz,
        measured=measured,
        model=model_signal(fit, measured.shape[1], rate_hz) if fit.verdict == "good" else None,
    )


def min_max_decimate(samples: NDArray[np.float64], points: int) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
    """Smallest and largest value per bucket, (c, buckets) each, and samples per bucket; no peak is lost."""
    size = max(1, -(-samples.shape[1] // points))
    buckets = -(-samples.shape[1] // size)
    padded = np.pad(samples, ((0, 0), (0, buckets * size - samples.shape[1])), mode="edge")
    cut = padded.reshape(samples.shape[0], buckets, size)
    return size, cut.min(axis=2), cut.max(axis=2)
