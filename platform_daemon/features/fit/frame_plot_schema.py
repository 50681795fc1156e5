"""A frame with its fit as numbers to draw."""

from __future__ import annotations

from pydantic import ConfigDict

from platform_daemon.core.schemas.base import Schema, example
from platform_daemon.core.schemas.fits import FrameFit


class FramePlot(Schema):
    """A stretch of a frame: what was measured, the fit, the residual, and the spectrum of the fitted window.

    Lists by channel have the shape (channels, points); a point holds `samples_per_point` samples.
    """

    model_config = ConfigDict(json_schema_extra=example("frame_plot"))

    fit: FrameFit
    """The fit that is drawn; where it is refused there is no model and no residual."""
    unit: str
    """Of the signal: "A m^2/s", or "V" without a calibration."""
    channels: tuple[str, ...]
    """World axes, or names of the receive channels."""
    duration_s: float
    """Length of the whole frame, s."""
    samples_per_point: int
    """1: every sample is there, and `model` too."""
    t_s: tuple[float, ...]
    """Time of each point, s after the first RX sample."""
    minimum: tuple[tuple[float, ...], ...]
    """Smallest value of each point, in `unit`."""
    maximum: tuple[tuple[float, ...], ...]
    """Largest value of each point, in `unit`."""
    model: tuple[tuple[float, ...], ...]
    """The fit at each sample, in `unit`; empty where a point holds several samples, or without a fit."""
    sigma: tuple[float, ...]
    """Standard deviation of the noise by channel, in `unit`; empty without a fit."""
    residual_minimum: tuple[tuple[float, ...], ...]
    """Smallest residual of each point, in standard deviations of the noise; empty without a fit."""
    residual_maximum: tuple[tuple[float, ...], ...]
    """Largest one; empty without a fit."""
    frequency_hz: tuple[float, ...]
    """Frequency of each point of the spectra, Hz."""
    spectrum: tuple[tuple[float, ...], ...]
    """Largest amplitude of the signal at each point, in `unit`."""
    residual_spectrum: tuple[tuple[float, ...], ...]
    """The same of the residual; empty without a fit."""
