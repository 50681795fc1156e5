"""The z residuals of recorded shots, each a file of its own while its series runs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from drivers.errors import RecordingError
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.features.fit.measurement import VoltageMeasurement
from platform_daemon.features.fit.online import NamedModel
from platform_daemon.features.models.adopted_model import AdoptedModel

if TYPE_CHECKING:
    from .predicted import PredictedThreshold

from .z_residual import ZNoise, ZResidual, z_residual


class RecordedSideModes:
    """What shots show out of the plane, against the noise of blank ones."""

    def __init__(self) -> None:
        self._noise: ZNoise | None = None

    def learn(self, blank: Sequence[Path]) -> None:
        """The noise, from shots without excitation, at least one.  Raises RecordingError as `of`."""
        windows = [_window(path) for path in blank]
        self._noise = ZNoise.of([samples for samples, _ in windows], windows[0][1])

    def of(self, shots: Sequence[Path]) -> list[ZResidual]:
        """Of shots that were not refused.

        Raises RecordingError for a shot that cannot be read, or without a calibration; ValueError before `learn`.
        """
        if self._noise is None:
            raise ValueError("the noise is not known yet")
        return [z_residual(samples, self._noise) for samples, _ in map(_window, shots)]

    def predicted(
        self, model: NamedModel, shot: Path, main_hz: float | None, lowest_t: float, highest_t: float
    ) -> PredictedThreshold:
        """See predicted_threshold.  Raises RecordingError; ValueError before `learn`."""
        from .predicted import predicted_threshold  # here, because the rotor's equations are loaded with it

        if self._noise is None:
            raise ValueError("the noise is not known yet")
        chosen = model.choice()
        assert isinstance(chosen, AdoptedModel)
        return predicted_threshold(chosen, shot, self._noise, main_hz, lowest_t, highest_t)


def _window(path: Path) -> tuple[Array, float]:
    """dm/dt (3, n), A m^2/s, and its rate, Hz."""
    measured = VoltageMeasurement.of(open_recording(path))
    record = measured.signal(0).record
    if record.quantity != "dmdt":
        remedy = "calibrate the receive side (platform-daemon calibrate rx)"
        raise RecordingError("without a calibration there is no z channel to look at", where=str(path), remedy=remedy)
    return record.samples[:, record.valid_from : record.valid_to], record.sampling_rate_hz
