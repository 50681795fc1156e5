"""Records that cannot be fitted are refused before any start value is sought."""

from __future__ import annotations

import numpy as np

from ..record import RingDownRecord
from ..refusal import Refusal, RefusedError
from .clipping import extremes, flat_runs, peaks_at, saturation
from .fundamental import SpectralPeak
from .oscillation import find_oscillation

FEWEST_PERIODS = 5.0
_FEWEST_SAMPLES = 64
_LARGEST = 1e100
_SIGNIFICANT = 60.0
_CLIPPED_SAMPLES = 8
_FLAT_RUNS = 8
_FEWEST_RUNS = 2


def screen(record: RingDownRecord) -> SpectralPeak:
    """Check a record's samples and find its oscillation.

    Raises:
        RefusedError: NaN, too short, clipped, no signal, sampled too slowly.
    """
    y = record.valid
    refuse_few_samples(y.shape[1])
    found = [extremes(channel) for channel in y]
    # Squares of larger numbers overflow; no unit makes them plausible. Comparisons with NaN are false.
    if not all(lowest > -_LARGEST and highest < _LARGEST for lowest, highest, _ in found):
        where = np.argwhere(~(np.abs(y) < _LARGEST).T)  # (sample, channel), in time
        sample, channel = record.valid_from + int(where[0, 0]), int(where[0, 1])
        raise RefusedError(Refusal.NOT_FINITE, f"{len(where)} samples, the first is {sample} of channel {channel}")
    for channel, extreme in enumerate(found):
        _refuse_clipped(record, channel, *extreme)
    line = find_oscillation(record)
    if line is None or line.significance < _SIGNIFICANT:
        strongest = "nothing at all" if line is None else f"a line at {line.frequency_hz:.1f} Hz"
        raise RefusedError(Refusal.NO_SIGNAL, f"the strongest feature is {strongest}")
    refuse_slow_sampling(record.sampling_rate_hz, line.frequency_hz)
    return line


def refuse_few_samples(samples: int) -> None:
    """Refuse what is too short for a look at its spectrum."""
    if samples < _FEWEST_SAMPLES:
        raise RefusedError(Refusal.TOO_SHORT, f"{samples} valid samples")


def refuse_slow_sampling(sampling_rate_hz: float, frequency_hz: float) -> None:
    """Refuse fewer than four samples per period."""
    if sampling_rate_hz < 4.0 * frequency_hz:
        seen = f"{sampling_rate_hz:.6g} Hz for an oscillation at {frequency_hz:.4g} Hz"
        raise RefusedError(Refusal.SAMPLING_TOO_SLOW, seen)


def refuse_few_periods(seconds: float, frequency_hz: float) -> None:
    """Refuse a window with fewer than FEWEST_PERIODS periods."""
    periods = seconds * frequency_hz
    if periods < FEWEST_PERIODS:
        raise RefusedError(Refusal.TOO_SHORT, f"{periods:.1f} periods of {frequency_hz:.1f} Hz")


def few_at_full_scale(record: RingDownRecord) -> tuple[str, ...]:
    """A warning about samples at full scale that were too few to be refused."""
    if record.full_scale is None:
        return ()
    clipped = int(np.count_nonzero(np.abs(record.valid) >= 0.9999 * record.full_scale))
    return (f"saturated: {clipped} samples at full scale, too few to spoil the result",) if clipped else ()


def _refuse_clipped(record: RingDownRecord, channel: int, lowest: float, highest: float, reached: int) -> None:
    """Samples at full scale, or flat tops: runs of equal values at a channel's extreme, again and again.

    reached: how many of every fourth sample are at the extreme, at least as many as there are runs.
    """
    y = record.valid[channel]
    if record.full_scale is not None and max(-lowest, highest) >= 0.9999 * record.full_scale:
        clipped = int(np.count_nonzero(np.abs(y) >= 0.9999 * record.full_scale))
        if clipped >= _CLIPPED_SAMPLES:
            raise RefusedError(Refusal.SATURATED, f"{clipped} samples of channel {channel} at full scale")
    if reached < _FEWEST_RUNS:
        return
    tops, bottoms = flat_runs(y, lowest, highest)
    for runs, extreme in ((tops, highest), (bottoms, lowest)):
        if runs < _FEWEST_RUNS or extreme == 0.0:
            continue
        # What is held at the extreme before its release is one top, however the steps of an encoder flicker.
        enough = (runs >= _FLAT_RUNS and record.quantity != "angle") or peaks_at(y, extreme) >= _FEWEST_RUNS
        # Coarse quantisation holds the top level too, but the next one as often.
        if enough and saturation(y[None]) is not None:
            raise RefusedError(Refusal.SATURATED, f"{runs} flat tops in channel {channel}")
