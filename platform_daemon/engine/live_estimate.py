"""The last shot at a glance, while a series runs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from platform_daemon import analysis
from platform_daemon.schemas import ShotHarmonics


class LiveEstimate:
    """Holds what the harmonics of the last excited shot tell; one thread writes it, anybody may read it."""

    latest: ShotHarmonics | None = None

    def see(
        self,
        acquisition: str,
        shot: int,
        rx_volts: NDArray[np.float64],
        rate_hz: float,
        calibration: ReceiveCalibration,
    ) -> None:
        """Look at shot number `shot` (from 1) of an acquisition."""
        found = analysis.shot_harmonics(rx_volts, rate_hz, calibration)
        self.latest = ShotHarmonics(found.model_copy(update={"acquisition": acquisition, "shot": shot}))
