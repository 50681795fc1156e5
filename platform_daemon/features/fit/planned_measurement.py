"""A planned measurement, whatever is to be fitted to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from drivers.specimen import Specimen
from platform_daemon.core.schemas.base import Window

from .prediction_schema import PredictionReport, WindowPrecision


@dataclass(frozen=True, eq=False)
class Plan:
    """What is common to all predictions.

    Attributes:
        windows: "n50", "d30" or seconds.
        noise_am2_per_s: (3,) standard deviation per sample.
        fixed: public names that the fit holds; expected: values by public name, SI.
    """

    specimen: Specimen
    windows: Sequence[Window]
    noise_am2_per_s: tuple[float, ...]
    sampling_rate_hz: float
    fixed: tuple[str, ...]
    expected: Mapping[str, float]

    def report(
        self, label: str, expected: dict[str, float], windows: Sequence[WindowPrecision], notes: tuple[str, ...]
    ) -> PredictionReport:
        """expected: all parameters of the planned motion."""
        return PredictionReport(
            variant=label,
            expected=expected,
            noise_sd_am2_per_s=self.noise_am2_per_s,
            sampling_rate_hz=self.sampling_rate_hz,
            windows=tuple(windows),
            notes=notes or None,
        )
