"""What a fit takes: the RX window of a frame as calibrated dm/dt, or as volts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError
from platform_daemon.adopted.receiver import undone
from platform_daemon.estimation import CalibrationError, RingDownRecord, calibrate
from platform_daemon.store import Calibration


def ring_down(
    rx_volts: NDArray[np.float64], rate_hz: float, calibration: Calibration | None
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
    return undone(record, calibration.sensitivity, calibration.receiver), tuple(done.notes)
