"""Records that cannot be fitted are refused before any start value is sought."""

from __future__ import annotations

import numpy as np

from ..record import RingDownRecord
from ..refusal import Refusal, RefusedError
from .angle_motion import few_swings, refuse_undying, still_angle
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
_GOOD_STRETCH = "write the longest stretch of finite samples to a file of its own"


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
        seen = f"{len(where)} samples, the first is {sample} of channel {channel}"
        raise RefusedError(Refusal.NOT_FINITE, seen, _GOOD_STRETCH if record.quantity == "angle" else "")
    for channel, extreme in enumerate(found):
        _refuse_clipped(record, channel, *extreme)
    still = record.quantity == "angle" and found[0][0] == found[0][1]
    line = None if still else find_oscillation(record)
    if line is None or line.significance < _SIGNIFICANT:
        if record.quantity == "angle":
            raise still_angle(y[0])
        strongest = "nothing at all" if line is None else f"a line at {line.frequency_hz:.1f} Hz"
        raise RefusedError(Refusal.NO_SIGNAL, f"the strongest feature is {strongest}")
    refuse_slow_sampling(record.sampling_rate_hz, line.frequency_hz)
    return line


def screen_free_swing(record: RingDownRecord) -> None:
    """Check an angle for what a free swing must have beside what every record must.

    Raises:
        RefusedError: as screen; too few periods; a swing that does not die away.
    """
    line = screen(record)
    refuse_few_swings(record, line.frequency_hz)
    refuse_undying(record, line.frequency_hz)


def refuse_few_swings(record: RingDownRecord, frequency_hz: float) -> None:
    """Refuse an angle with fewer than FEWEST_PERIODS periods in all."""
    y = record.valid[0]
    if y.size * record.dt_s * frequency_hz < FEWEST_PERIODS:
        raise few_swings(y, record.dt_s, FEWEST_PERIODS)


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
