"""Angle records in which nothing swings, too little does, or nothing dies away."""

from __future__ import annotations

import math

import numpy as np

from ..numerics.arrays import Array
from ..record import RingDownRecord
from ..refusal import Refusal, RefusedError
from .angle_cycles import HalfCycles, find_half_cycles

_RELEASE = "record the swing from its release on: a rest holds nothing to fit"
_LEVEL = 0.3  # of the half range: a passage goes from beyond it to beyond it on the other side
_MANY = 20  # half cycles, from which a swing must be seen to die away
_SURE = 5.0  # standard errors
_LOSSLESS_Q = 5e4  # beyond that of swings whose angle is read
_REVIVED = 0.25  # of the largest swing: how much it must come back
_GRADUAL = 7  # half cycles that a return takes at least: a push is sudden
_STEP = 0.5  # of a return in one period: a push
_SMOOTHED = 5  # half cycles
_DITHERED = 0.03  # scatter over an encoder's step: below, its steps are the same in every period, and say nothing


def still_angle(y: Array) -> RefusedError:
    """Why an angle (n,) holds no oscillation."""
    lowest, highest = float(y.min()), float(y.max())
    if lowest == highest:
        return RefusedError(Refusal.NO_SIGNAL, f"every sample is {lowest:.6g} rad: nothing moves", _RELEASE)
    seen = f"the angle stays between {lowest:.4g} and {highest:.4g} rad, and nothing in it swings"
    return RefusedError(Refusal.NO_SIGNAL, seen, _RELEASE)


def few_swings(y: Array, dt_s: float, fewest: float) -> RefusedError:
    """Why an angle (n,) holds too few periods; fewest: that are needed."""
    middle, half = 0.5 * float(y.max() + y.min()), 0.5 * float(y.max() - y.min())
    sides = np.sign(y - middle)[np.abs(y - middle) > _LEVEL * half]
    passages = int(np.count_nonzero(np.diff(sides)))
    seen = f"{passages} passages through the middle in {y.size * dt_s:.3g} s, about {0.5 * passages:.1f} periods"
    return RefusedError(Refusal.TOO_SHORT, seen, f"record at least {fewest:g} periods")


def refuse_undying(record: RingDownRecord, frequency_hz: float) -> None:
    """Refuse an angle whose swing comes back, grows, or does not die away where any loss would show.

    Raises:
        RefusedError: with what was seen and where.
    """
    y = record.samples[0, record.valid_from : record.end]
    cycles = find_half_cycles(y, record.valid_from, record.dt_s, frequency_hz)
    if cycles is None or cycles.turning_rad.size < _MANY:
        return
    time, size = _sizes(cycles, y, record)
    if not np.all(size > 0.0):
        return
    seen = _return(time, size) or _no_decay(time, size, _smallest_step(y))
    if seen is not None:
        raise RefusedError(Refusal.NO_DECAY, seen)


def _sizes(cycles: HalfCycles, y: Array, record: RingDownRecord) -> tuple[Array, Array]:
    """Times (k - 1,) in s and sizes of the swing in rad, from all samples of two half cycles, whatever its zero is."""
    x = y - cycles.zero_rad
    at = (record.valid_from + np.arange(y.size)) * record.dt_s
    area = np.interp(cycles.passages_s, at, record.dt_s * (np.cumsum(x) - 0.5 * x))
    size = 0.5 * math.pi * np.abs(np.diff(area)) / np.diff(cycles.passages_s)
    middle = 0.5 * (cycles.passages_s[1:] + cycles.passages_s[:-1])
    return 0.5 * (middle[1:] + middle[:-1]), 0.5 * (size[1:] + size[:-1])


def _return(time: Array, size: Array) -> str | None:
    """A swing that gradually comes back, as beside a drive or another oscillation; not one that is pushed once."""
    from scipy.signal import medfilt  # here: it takes longer to load than everything else that a fit of dm/dt needs

    smooth = np.asarray(medfilt(size, _SMOOTHED))[2:-2]
    time = time[2:-2]
    low = np.minimum.accumulate(smooth)
    top = int(np.argmax(smooth - low))
    bottom = int(np.flatnonzero(smooth[: top + 1] == low[top])[-1])
    rise = float(smooth[top] - smooth[bottom])
    if rise < _REVIVED * float(smooth.max()) or top - bottom < _GRADUAL:
        return None
    if float(np.max(smooth[bottom + 2 : top + 1] - smooth[bottom : top - 1])) > _STEP * rise:
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
    if float(np.std(rest)) * float(size.mean()) < _DITHERED * step_rad:
        error += step_rad / (float(size.mean()) * span)
    w = math.pi / float(np.median(np.diff(time)))
    told = f"its {time.size // 2} periods"
    if growth > _SURE * error and _usual_growth(time, y) > 0.0:
        return f"the swing grows by {100.0 * growth * span:.2g} % in {told}: is it driven?"
    least = 0.5 * w / _LOSSLESS_Q
    if abs(growth) < _SURE * error and _SURE * error - growth < least and abs(_usual_growth(time, y)) < least:
        bound = 100.0 * (_SURE * error - growth) * span
        return f"the swing does not die away: it loses less than {bound:.1g} % in {told}: is it driven?"
    return None


def _error(rest: Array) -> float:
    """Standard deviation of residuals (n,), widened as much as they go on from one to the next."""
    square = float(rest @ rest)
    if square <= 0.0:
        return 0.0
    along = min(max(float(rest[1:] @ rest[:-1]) / square, 0.0), 0.95)
    return math.sqrt(square / (rest.size - 2) * (1.0 + along) / (1.0 - along))


def _usual_growth(time: Array, y: Array) -> float:
    """Of most pairs a sixth of the record apart, 1/s: a single push leaves it as it is."""
    apart = max(1, time.size // 6)
    return float(np.median((y[apart:] - y[:-apart]) / (time[apart:] - time[:-apart])))


def _smallest_step(y: Array) -> float:
    """Of samples that differ at all, rad."""
    moves = np.abs(np.diff(y[:100_000]))
    return float(np.min(moves[moves > 1e-9 * np.abs(y).max()], initial=math.inf)) if moves.any() else 0.0
