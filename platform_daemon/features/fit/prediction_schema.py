"""What a planned measurement can tell: the Cramér-Rao bound, white noise."""

from __future__ import annotations

from pydantic import ConfigDict

from platform_daemon.core.schemas.base import Absent, Schema, Window, example


class WindowPrecision(Schema):
    """The smallest standard deviations that an evaluation window can reach."""

    window: Window
    """Window that was requested: n50, d30, or seconds."""
    window_s: float
    """Its length for the planned motion, s."""
    std: dict[str, float]
    """Smallest standard deviation by public name, in the SI unit that the name holds."""
    orientation_rad: float
    """Root mean square angle between estimated and true orientation, rad."""


class PredictionReport(Schema):
    """How precise a planned measurement can be at best, per window."""

    model_config = ConfigDict(json_schema_extra=example("prediction_report"))

    variant: str
    """Model that is to be fitted."""
    expected: dict[str, float]
    """Parameters of the planned motion by public name, SI."""
    noise_sd_am2_per_s: tuple[float, ...]
    """Standard deviation of the noise of x, y, z per sample, A m^2/s, (3,)."""
    sampling_rate_hz: float
    """Sampling rate, Hz."""
    windows: tuple[WindowPrecision, ...]
    """Window by window."""
    notes: Absent[tuple[str, ...]] = None
    """Of an adopted model, what the bound holds for; absent: nothing is to be said."""
