"""Where the oscillation of a record is: of dm/dt, of volts, or of an angle."""

from __future__ import annotations

from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.thresholds import THRESHOLDS

from .angle_cycles import find_angle_frequency
from .fundamental import SpectralPeak, find_fundamental

LIMITS = THRESHOLDS.screening


def find_oscillation(record: RingDownRecord) -> SpectralPeak | None:
    """The fundamental of dm/dt or volts, the swings of an angle; None if there is nothing to see."""
    if record.quantity == "angle":
        return find_angle_frequency(record.valid, record.sampling_rate_hz)
    if record.quantity == "dmdt":
        # Else hum at half the frequency would be taken for the fundamental.
        return find_fundamental(record.valid, record.sampling_rate_hz, LIMITS.fundamental_weakest_share_dmdt)
    return find_fundamental(record.valid, record.sampling_rate_hz)
