"""What is drawn, without the library that draws it, which takes longer to load than a fit to make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from platform_daemon.core.schemas.base import Window
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.result import FitResult, model_signal
from platform_daemon.features.models.resolve import ModelChoice

from .fit import fit_signal
from .fit_request import FitRequest
from .measurement import Measurement, VoltageMeasurement

_UNITS = {"dmdt": "dm/dt / A m² s⁻¹", "voltage": "ADC input / V", "angle": "φ / rad"}


@dataclass(frozen=True)
class RingDownPlotData:
    """What a picture shows.

    measured and model: (c, n) in `unit`, model None if the fit was refused (then there is no residual either);
    sampling rate Hz; calibrated: the signal is dm/dt, and not the voltage.
    """

    title: str
    fit: FitResult
    unit: str
    channels: tuple[str, ...]
    sampling_rate_hz: float
    measured: NDArray[np.float64]
    model: NDArray[np.float64] | None
    calibrated: bool


def ring_down_plot_data(
    measurement: Measurement, frame: int, model: ModelChoice | None, window: Window, terms: Sequence[str] = ()
) -> RingDownPlotData:
    """What to draw of one frame: its calibrated signal with the fit over it, or without if the fit was refused."""
    used, chosen = measurement.under(model, terms)
    signal = used.signal(frame)
    ask = FitRequest(chosen, window, weight_over_pull=used.weight_over_pull())
    return plot_data_of(used, frame, signal.record, fit_signal(signal, ask, used.noise()))


def plot_data_of(measurement: Measurement, frame: int, record: RingDownRecord, fit: FitResult) -> RingDownPlotData:
    """What to draw of one frame, its signal as it was fitted, and its fit."""
    measured, rate_hz, quantity = record.samples, record.sampling_rate_hz, record.quantity
    calibrated = quantity == "dmdt"
    provenance = measurement.recording.provenance if isinstance(measurement, VoltageMeasurement) else None
    names = {"dmdt": tuple("xyz"), "angle": ("φ",)}.get(quantity) or (provenance.channel_names if provenance else ())
    return RingDownPlotData(
        title=f"{measurement.path.name}, frame {frame}",
        fit=fit,
        unit=_UNITS[quantity],
        channels=names or tuple(map(str, range(measured.shape[0]))),
        sampling_rate_hz=rate_hz,
        measured=measured,
        model=model_signal(fit, measured.shape[1], rate_hz) if fit.verdict == "good" else None,
        calibrated=calibrated,
    )
