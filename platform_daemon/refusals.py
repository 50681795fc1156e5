"""What is refused before anything is fitted, in the words of a fit's refusals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.errors import PlatformError
from platform_daemon.estimation import find_clipping
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.signal.saturation import Clipping
from platform_daemon.store import NotFinite


def reason_of(error: PlatformError) -> str:
    """Why a frame that cannot be read is refused."""
    return str(RefusedError(Refusal.NOT_FINITE, error.seen)) if isinstance(error, NotFinite) else str(error)


def checked_clipping(rx_volts: NDArray[np.float64]) -> Clipping | None:
    """Clipping of raw volts (c, n) that does no harm, None without; whatever a calibration mixes afterwards.

    Raises RefusedError if it would spoil the result.
    """
    clipped = find_clipping(rx_volts)
    if clipped is not None and clipped.severe:
        raise RefusedError(Refusal.SATURATED, str(clipped))
    return clipped
