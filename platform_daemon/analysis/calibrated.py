"""What is refused before anything is fitted, in the words of a fit's refusals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration
from drivers.errors import PlatformError, RecordingError
from platform_daemon.estimation import (
    CalibrationError,
    Clipping,
    Refusal,
    RefusedError,
    RingDownRecord,
    calibrate,
    correct_receiver_effects,
    find_clipping,
)
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


def ring_down(
    rx_volts: NDArray[np.float64], rate_hz: float, calibration: ReceiveCalibration | None
) -> tuple[RingDownRecord, tuple[str, ...]]:
    """The record that a fit takes: calibrated dm/dt (3, n) A m^2/s, or volts (c, n) if there is no calibration.

    With it, what the calibration had to assume.

    Raises RecordingError if the calibration does not fit the data.
    """
    if calibration is None:
        return RingDownRecord(samples=rx_volts, sampling_rate_hz=rate_hz, quantity="voltage"), ()
    try:
        done = calibrate(
            rx_volts, rate_hz, calibration.sensitivity, calibration.frequency_hz, calibration.frequency_response
        )
    except CalibrationError as error:
        where = f"calibration {calibration.identifier or 'of the file'}"
        raise RecordingError(str(error), where=where, remedy="calibrate again, or give another calibration") from None
    record = RingDownRecord(
        samples=done.dmdt,
        sampling_rate_hz=rate_hz,
        quantity="dmdt",
        valid_from=done.valid_from,
        valid_to=done.valid_to,
    )
    return correct_receiver_effects(record, calibration.sensitivity, calibration.receiver), tuple(done.notes)
