"""Records that cannot be fitted are refused before any start value is sought."""

from __future__ import annotations

import numpy as np

from .record import RingDownRecord
from .refusal import Refusal, RefusedError
from .spectrum import Line, find_fundamental

FEWEST_PERIODS = 5.0
_FEWEST_SAMPLES = 64
_LARGEST = 1e100
_SIGNIFICANT = 60.0
_CLIPPED_SAMPLES = 8
_FLAT_RUNS = 8


def screen(record: RingDownRecord) -> Line:
    """Check a record's samples and find its oscillation.

    Raises:
        RefusedError: NaN, too short, clipped, no signal, sampled too slowly.
    """
    y = record.valid
    if y.shape[1] < _FEWEST_SAMPLES:
        raise RefusedError(Refusal.TOO_SHORT, f"{y.shape[1]} valid samples")
    # Squares of larger numbers overflow; no unit makes them plausible.
    bad = np.flatnonzero(~(np.abs(y) < _LARGEST).all(axis=0))
    if bad.size:
        raise RefusedError(Refusal.NOT_FINITE, f"{bad.size} samples, the first at {record.valid_from + int(bad[0])}")
    _refuse_clipped(record)
    line = find_fundamental(y, record.sampling_rate_hz)
    if line is None or line.significance < _SIGNIFICANT:
        strongest = "nothing at all" if line is None else f"a line at {line.frequency_hz:.1f} Hz"
        raise RefusedError(Refusal.NO_SIGNAL, f"the strongest feature is {strongest}")
    if record.sampling_rate_hz < 4.0 * line.frequency_hz:
        raise RefusedError(
            Refusal.SAMPLING_TOO_SLOW,
            f"{record.sampling_rate_hz:.6g} Hz for an oscillation at {line.frequency_hz:.4g} Hz",
        )
    return line


def refuse_few_periods(seconds: float, frequency_hz: float) -> None:
    """Refuse a window with fewer than FEWEST_PERIODS periods."""
    periods = seconds * frequency_hz
    if periods < FEWEST_PERIODS:
        raise RefusedError(Refusal.TOO_SHORT, f"{periods:.1f} periods of {frequency_hz:.1f} Hz")


def _refuse_clipped(record: RingDownRecord) -> None:
    """Samples at full scale, or flat tops: runs of equal values at a channel's extreme, again and again."""
    for channel, y in enumerate(record.valid):
        if record.full_scale is not None:
            clipped = int(np.count_nonzero(np.abs(y) >= 0.9999 * record.full_scale))
            if clipped >= _CLIPPED_SAMPLES:
                raise RefusedError(Refusal.SATURATED, f"{clipped} samples of channel {channel} at full scale")
        for extreme in (float(y.max()), float(y.min())):
            runs = _flat_runs(y, extreme)
            if runs >= _FLAT_RUNS and extreme != 0.0:
                raise RefusedError(Refusal.SATURATED, f"{runs} flat tops in channel {channel}")


def _flat_runs(y: np.ndarray, extreme: float) -> int:
    """How many runs of at least four samples sit at the extreme."""
    at = np.concatenate([[False], np.abs(y - extreme) <= 1e-9 * abs(extreme), [False]])
    edges = np.flatnonzero(at[1:] != at[:-1])
    return int(np.count_nonzero(edges[1::2] - edges[::2] >= 4))
