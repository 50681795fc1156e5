"""What a page draws of a frame: the arrays of a picture, made fewer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.errors import InputError

from .decimation import min_max_decimate
from .fit import frame_report
from .frame_plot_schema import FramePlot
from .plot_data import RingDownPlotData

_SHOWN_HZ = 20.0, 2500.0
"""Lowest and highest frequency of the spectra: those of the picture."""
_Values = tuple[tuple[float, ...], ...]


def frame_plot(
    picture: RingDownPlotData, frame: int, points: int, start_s: float, stop_s: float | None, where: str
) -> FramePlot:
    """The stretch of frame number `frame` from start_s to stop_s, None: to the end, in at most `points` points.

    Raises InputError for a stretch without samples.
    """
    measured, model, rate_hz = picture.measured, picture.model, picture.sampling_rate_hz
    n = measured.shape[1]
    first, last = round(start_s * rate_hz), n if stop_s is None else min(n, round(stop_s * rate_hz))
    if not 0 <= first < last:
        remedy = f"ask for times from 0 to {n / rate_hz:.6f} s, start_s before stop_s"
        raise InputError("the time range holds no samples of this frame", where=where, remedy=remedy)
    size, low, high = min_max_decimate(measured[:, first:last], points)
    residual = None if model is None else measured - model
    sigma = None if residual is None else _noise(picture, residual)
    frequency_hz, spectrum = _spectrum(picture, measured, points)
    scaled = None if residual is None or sigma is None else residual[:, first:last] / sigma[:, None]
    below, above = ((), ()) if scaled is None else map(_values, min_max_decimate(scaled, points)[1:])
    return FramePlot(
        fit=frame_report(frame, picture.fit),
        unit="A m^2/s" if picture.calibrated else "V",
        channels=picture.channels,
        duration_s=n / rate_hz,
        samples_per_point=size,
        t_s=tuple(((first + size * np.arange(low.shape[1])) / rate_hz).tolist()),
        minimum=_values(low),
        maximum=_values(high),
        model=() if model is None or size > 1 else _values(model[:, first:last]),
        sigma=() if sigma is None else tuple(sigma.tolist()),
        residual_minimum=below,
        residual_maximum=above,
        frequency_hz=tuple(frequency_hz.tolist()),
        spectrum=_values(spectrum),
        residual_spectrum=() if residual is None else _values(_spectrum(picture, residual, points)[1]),
    )


def _values(array: NDArray[np.float64]) -> _Values:
    """Lists by channel; seven digits are more than a screen shows."""
    return tuple(tuple(float(f"{value:.7g}") for value in row) for row in array.tolist())


def _fitted(picture: RingDownPlotData) -> int:
    """Samples of the fitted window; without a fit all."""
    n, window_s = picture.measured.shape[1], picture.fit.window_s
    return n if window_s is None else max(2, min(n, round(window_s * picture.sampling_rate_hz)))


def _noise(picture: RingDownPlotData, residual: NDArray[np.float64]) -> NDArray[np.float64]:
    """Standard deviation of the noise by channel: that for which the residual of the window has its chi^2."""
    rms = np.sqrt(np.mean(residual[:, : _fitted(picture)] ** 2, axis=1))
    chi2 = picture.fit.chi2_per_dof_by_channel
    return rms if chi2 is None else rms / np.sqrt(np.asarray(chi2))


def _spectrum(
    picture: RingDownPlotData, signal: NDArray[np.float64], points: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequencies (m,), Hz, and the largest amplitudes there (channels, m) of the fitted window of a signal."""
    n = _fitted(picture)
    window = np.blackman(n)
    found = np.fft.rfftfreq(n, 1 / picture.sampling_rate_hz)
    shown = (found > _SHOWN_HZ[0]) & (found < _SHOWN_HZ[1])
    lines = np.abs(np.fft.rfft(signal[:, :n] * window))[:, shown] * 2 / window.sum()
    size, _, high = min_max_decimate(lines, points)
    return np.asarray(found[shown][::size], dtype=np.float64), high
