"""Where the oscillation of a record is, whatever the record reads."""

from __future__ import annotations

from ..record import RingDownRecord
from .angle_cycles import find_angle_frequency
from .fundamental import SpectralPeak, find_fundamental

_WEAKEST_DMDT = 0.05  # of the power at 2f, over three axes: below 97 degrees the fundamental is the stronger one


def find_oscillation(record: RingDownRecord) -> SpectralPeak | None:
    """The fundamental of dm/dt or volts, the swings of an angle; None if there is nothing to see."""
    if record.quantity == "angle":
        return find_angle_frequency(record.valid, record.sampling_rate_hz)
    if record.quantity == "dmdt":
        # Else hum at half the frequency would be taken for the fundamental.
        return find_fundamental(record.valid, record.sampling_rate_hz, _WEAKEST_DMDT)
    return find_fundamental(record.valid, record.sampling_rate_hz)
