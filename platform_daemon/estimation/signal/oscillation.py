"""Where the oscillation of a record is, whatever the record reads."""

from __future__ import annotations

from ..record import RingDownRecord
from .spectrum import Line, find_fundamental
from .swings import find_swing


def find_oscillation(record: RingDownRecord) -> Line | None:
    """The fundamental of dm/dt or volts, the swings of an angle; None if there is nothing to see."""
    find = find_swing if record.quantity == "angle" else find_fundamental
    return find(record.valid, record.sampling_rate_hz)
