"""Two resonators in one record, near each other or far, named without any model of the motion."""

from __future__ import annotations

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import Refusal, RefusedError

from .beat import find_beat
from .separate_lines import find_far_lines


def refuse_two_lines(record: RingDownRecord, frequency_hz: float, noise_sd: Array) -> None:
    """Refuse a record that beats, or holds two lines of which none is a harmonic; noise_sd (channels,) of a sample."""
    found = find_beat(record, first=record.valid_from, last=record.end, frequency_hz=frequency_hz, noise_sd=noise_sd)
    found = find_far_lines(record, frequency_hz) if found is None else found
    if found is not None:
        one, other = found.frequencies_hz
        seen = f"{one:.6g} Hz and {other:.6g} Hz, the second with {100.0 * found.ratio:.2g} % of the first's size"
        raise RefusedError(Refusal.TWO_RESONATORS, seen)
