"""Angle records without an oscillation, with too small a one, or with one that does not decay."""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.thresholds import THRESHOLDS

from .angle_cycles import HalfCycles, find_half_cycles

LIMITS = THRESHOLDS.screening

_RELEASE = "record the swing from its release on: a rest holds nothing to fit"


def still_angle(y: Array) -> RefusedError:
    """The refusal of an angle (n,), rad, that holds no oscillation; it is returned, not raised."""
    lowest, highest = float(y.min()), float(y.max())
    if lowest == highest:
        return RefusedError(Refusal.NO_SIGNAL, f"every sample is {lowest:.6g} rad: nothing moves", _RELEASE)
    seen = f"the angle stays between {lowest:.4g} and {highest:.4g} rad, and nothing in it swings"
    return RefusedError(Refusal.NO_SIGNAL, seen, _RELEASE)


def few_swings(y: Array, *, dt_s: float, fewest: float) -> RefusedError:
    """Why an angle (n,) holds too few periods; fewest: that are needed."""
    middle, half = 0.5 * float(y.max() + y.min()), 0.5 * float(y.max() - y.min())
    sides = np.sign(y - middle)[np.abs(y - middle) > LIMITS.passage_level_share * half]
    passages = int(np.count_nonzero(np.diff(sides)))
    seen = f"{passages} passages through the middle in {y.size * dt_s:.3g} s, about {0.5 * passages:.1f} periods"
    return RefusedError(Refusal.TOO_SHORT, seen, f"record at least {fewest:g} periods")


def refuse_undying(record: RingDownRecord, frequency_hz: float) -> None:
    """Refuse an angle whose swing comes back, grows, or does not die away where any loss would show.

    Raises:
        RefusedError: with what was seen and where.
    """
    y = record.samples[0, record.valid_from : record.end]
    cycles = find_half_cycles(y, first=record.valid_from, dt_s=record.dt_s, frequency_hz=frequency_hz)
    if cycles is None or cycles.turning_rad.size < LIMITS.decay_half_cycles:
        return
    time, size = _sizes(cycles, y, record)
    if not np.all(size > 0.0):
        return
    seen = _return(time, size) or _no_decay(time, size, _smallest_step(y))
    if seen is not None:
        raise RefusedError(Refusal.NO_DECAY, seen)


def _sizes(cycles: HalfCycles, y: Array, record: RingDownRecord) -> tuple[Array, Array]:
    """Times (k - 1,) in s and sizes of the swing in rad, from all samples of two half cycles; the zero cancels."""
    x = y - cycles.zero_rad
    at = (record.valid_from + np.arange(y.size)) * record.dt_s
    area = np.interp(cycles.passages_s, at, record.dt_s * (np.cumsum(x) - 0.5 * x))
    size = 0.5 * math.pi * np.abs(np.diff(area)) / np.diff(cycles.passages_s)
    middle = 0.5 * (cycles.passages_s[1:] + cycles.passages_s[:-1])
    return 0.5 * (middle[1:] + middle[:-1]), 0.5 * (size[1:] + size[:-1])


def _return(time: Array, size: Array) -> str | None:
    """A swing that gradually comes back, as with a drive or another oscillation; not one that is pushed once."""
    from scipy.signal import medfilt  # here: it takes longer to load than everything else that a fit of dm/dt needs

    smooth = np.asarray(medfilt(size, LIMITS.median_half_cycles))[2:-2]
    time = time[2:-2]
    low = np.minimum.accumulate(smooth)
    top = int(np.argmax(smooth - low))
    bottom = int(np.flatnonzero(smooth[: top + 1] == low[top])[-1])
    rise = float(smooth[top] - smooth[bottom])
    if rise < LIMITS.revival_share * float(smooth.max()) or top - bottom < LIMITS.revival_half_cycles:
        return None
    if float(np.max(smooth[bottom + 2 : top + 1] - smooth[bottom : top - 1])) > LIMITS.push_share * rise:
        return None
    return (
        f"the swing grows from {smooth[bottom]:.3g} rad at {time[bottom]:.3g} s to {smooth[top]:.3g} rad at "
        f"{time[top]:.3g} s: is it driven, or does a second oscillation beat with it?"
    )


def _no_decay(time: Array, size: Array, step_rad: float) -> str | None:
    """A swing that grows by more than its errors, or is steady where any loss would show."""
    x, y = time - time.mean(), np.log(size)
    power = float(x @ x)
    growth = float(x @ y) / power
    rest = y - y.mean() - growth * x
    error = _error(rest) / math.sqrt(power)
    span = float(time[-1] - time[0])
    if float(np.std(rest)) * float(size.mean()) < LIMITS.dithered_share * step_rad:
        error += step_rad / (float(size.mean()) * span)
    w = math.pi / float(np.median(np.diff(time)))
    periods = f"its {time.size // 2} periods"
    if growth > LIMITS.decay_sigma * error and _usual_growth(time, y) > 0.0:
        return f"the swing grows by {100.0 * growth * span:.2g} % in {periods}: is it driven?"
    least = 0.5 * w / LIMITS.lossless_quality
    if (
        abs(growth) < LIMITS.decay_sigma * error
        and LIMITS.decay_sigma * error - growth < least
        and abs(_usual_growth(time, y)) < least
    ):
        bound = 100.0 * (LIMITS.decay_sigma * error - growth) * span
        return f"the swing does not die away: it loses less than {bound:.1g} % in {periods}: is it driven?"
    return None


def _error(rest: Array) -> float:
    """Standard deviation of residuals (n,), widened by the correlation of neighbouring ones."""
    square = float(rest @ rest)
    if square <= 0.0:
        return 0.0
    along = min(max(float(rest[1:] @ rest[:-1]) / square, 0.0), LIMITS.largest_autocorrelation)
    return math.sqrt(square / (rest.size - 2) * (1.0 + along) / (1.0 - along))


def _usual_growth(time: Array, y: Array) -> float:
    """Of most pairs a sixth of the record apart, 1/s: a single push leaves it as it is."""
    apart = max(1, time.size // LIMITS.growth_pair_divisor)
    return float(np.median((y[apart:] - y[:-apart]) / (time[apart:] - time[:-apart])))


def _smallest_step(y: Array) -> float:
    """Of samples that differ at all, rad."""
    moves = np.abs(np.diff(y[: LIMITS.encoder_samples]))
    return float(np.min(moves[moves > LIMITS.equal_share * np.abs(y).max()], initial=math.inf)) if moves.any() else 0.0
