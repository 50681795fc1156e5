"""Records that cannot be fitted are refused before any start value is sought."""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.thresholds import THRESHOLDS

from .angle_motion import few_swings, refuse_undying, still_angle
from .clipping import extremes, flat_runs, peaks_at, saturation
from .fundamental import SpectralPeak
from .oscillation import find_oscillation

LIMITS = THRESHOLDS.screening
FEWEST_PERIODS = LIMITS.fewest_periods

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
    if not all(lowest > -LIMITS.largest_value and highest < LIMITS.largest_value for lowest, highest, _ in found):
        where = np.argwhere(~(np.abs(y) < LIMITS.largest_value).T)  # (sample, channel), in time
        sample, channel = record.valid_from + int(where[0, 0]), int(where[0, 1])
        seen = f"{len(where)} samples, the first is {sample} of channel {channel}"
        raise RefusedError(Refusal.NOT_FINITE, seen, _GOOD_STRETCH if record.quantity == "angle" else "")
    for channel, (lowest, highest, reached) in enumerate(found):
        _refuse_clipped(record, channel, lowest=lowest, highest=highest, reached=reached)
    still = record.quantity == "angle" and found[0][0] == found[0][1]
    line = None if still else find_oscillation(record)
    if line is None or line.significance < LIMITS.line_significance:
        if record.quantity == "angle":
            raise still_angle(y[0])
        strongest = "nothing at all" if line is None else f"a line at {line.frequency_hz:.1f} Hz"
        raise RefusedError(Refusal.NO_SIGNAL, f"the strongest feature is {strongest}")
    refuse_slow_sampling(record.sampling_rate_hz, line.frequency_hz)
    return line


def screen_free_swing(record: RingDownRecord) -> None:
    """Check an angle for all that a record must have, and for what a free swing must have besides.

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
        raise few_swings(y, dt_s=record.dt_s, fewest=FEWEST_PERIODS)


def refuse_few_samples(samples: int) -> None:
    """Refuse what is too short for a look at its spectrum."""
    if samples < LIMITS.fewest_samples:
        raise RefusedError(Refusal.TOO_SHORT, f"{samples} valid samples")


def refuse_slow_sampling(sampling_rate_hz: float, frequency_hz: float) -> None:
    """Refuse fewer than four samples per period."""
    if sampling_rate_hz < LIMITS.samples_per_period * frequency_hz:
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
    clipped = int(np.count_nonzero(np.abs(record.valid) >= LIMITS.full_scale_share * record.full_scale))
    return (f"saturated: {clipped} samples at full scale, too few to spoil the result",) if clipped else ()


def _refuse_clipped(record: RingDownRecord, channel: int, *, lowest: float, highest: float, reached: int) -> None:
    """Samples at full scale, or flat tops: runs of equal values at a channel's extreme, again and again.

    reached: how many of every fourth sample are at the extreme, at least as many as there are runs.
    """
    y = record.valid[channel]
    if record.full_scale is not None and max(-lowest, highest) >= LIMITS.full_scale_share * record.full_scale:
        clipped = int(np.count_nonzero(np.abs(y) >= LIMITS.full_scale_share * record.full_scale))
        if clipped >= LIMITS.full_scale_samples:
            raise RefusedError(Refusal.SATURATED, f"{clipped} samples of channel {channel} at full scale")
    if reached < LIMITS.fewest_flat_runs:
        return
    tops, bottoms = flat_runs(y, lowest, highest)
    for runs, extreme in ((tops, highest), (bottoms, lowest)):
        if runs < LIMITS.fewest_flat_runs or extreme == 0.0:
            continue
        # What is held at the extreme before its release is one top, however the steps of an encoder flicker.
        enough = (runs >= LIMITS.flat_runs and record.quantity != "angle") or peaks_at(
            y, extreme
        ) >= LIMITS.fewest_flat_runs
        # Coarse quantisation holds the top level too, but the next one as often.
        if enough and saturation(y[None]) is not None:
            raise RefusedError(Refusal.SATURATED, f"{runs} flat tops in channel {channel}")
