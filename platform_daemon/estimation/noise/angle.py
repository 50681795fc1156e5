"""Noise of an angle: from high differences of its samples, because an oscillation is smooth and noise is not.

Beside the few harmonics of a swing that dies away over many periods stands the swing's own leakage, which is larger
than the noise of any encoder. Differences of a high order between neighbouring samples, and between means of
neighbouring samples, hold nothing of a smooth motion. They tell the noise from half the sampling rate down to some
ten times the swing's frequency; steps of an encoder that is read more often than it counts are slow, so the scale
where it is largest counts.
"""

from __future__ import annotations

import math

import numpy as np

from ..numerics.arrays import Array
from ..record import RingDownRecord

_ORDER = 8
_PER_PERIOD = 24.0  # samples at least: of a sine of 1 rad the differences then leave 1e-7 rad
_MEANS_PER_PERIOD = 60.0  # the same of means: kinks, where dry friction changes its sign, stand in few of them
_WAVE_PERIODS, _HARMONICS, _DEGREES = 3.0, 4, 3  # of windows at fewer samples than that
_FREE = 6  # samples beyond the columns of a window
_DETUNED = tuple(0.01 * k for k in range(85, 111))  # times the frequency of the line
_FEWEST = 32  # differences
_CELLS = 4  # per period: what breaks the motion's smoothness stands in few of them
_BROKEN = 25.0  # times the usual power: a kink or a jump, no noise
_RISE = 1.5  # from one scale to the next, twice as long: beyond that it is motion, no noise
_LOOKED_AT = 100_000  # differences, for the size of a step
_FEW_STEPS, _OFF_STEP = 50.0, 0.05  # of an encoder, a move of a few counts is a whole number of them


def angle_noise_sd(record: RingDownRecord, frequency_hz: float) -> float | None:
    """Standard deviation of a sample, were the noise white at its level near the swing's harmonics, in rad.

    None if there are too few samples per period, or too few at all, to tell noise from motion.
    """
    y, rate = record.valid[0], record.sampling_rate_hz
    levels: list[float] = []
    block, fewest = 1, _PER_PERIOD
    while rate / (block * frequency_hz) >= fewest and y.size // block >= _FEWEST + _ORDER:
        level = _level(y, block, rate / (block * frequency_hz))
        if levels and level > _RISE * max(levels[-1], _step(y) / math.sqrt(12.0)):
            break
        levels.append(level)
        block, fewest = 2 * block, _MEANS_PER_PERIOD
    if not levels:
        levels = _beside_waves(y, rate / frequency_hz)
    return max(*levels, _step(y) / math.sqrt(12.0)) if levels else None


def _beside_waves(y: Array, per_period: float) -> list[float]:
    """The level of what is no sum of harmonics of slowly changing size in windows of few periods; none if too few.

    For records with few samples per period, whose differences hold the swing itself.
    """
    width = round(_WAVE_PERIODS * per_period)
    harmonics = min(_HARMONICS, int(0.45 * per_period))
    columns = _DEGREES * (2 * harmonics + 1)
    if harmonics < 2 or width < columns + _FREE or y.size < 2 * width:
        return []
    starts = range(0, y.size - width + 1, width // 2)
    time = np.asarray(np.arange(width) - 0.5 * (width - 1), dtype=np.float64)
    left = np.full(len(starts), np.inf)
    windows = np.stack([y[k : k + width] for k in starts], axis=1)
    for share in _DETUNED:  # a large swing is slower than a small one
        q = np.linalg.qr(_waves(time, share / per_period, harmonics))[0]
        rest = windows - q @ (q.T @ windows)
        left = np.minimum(left, np.sum(rest**2, axis=0))
    # A kick or a jump stands in few windows; of chi^2 the median is a little below the mean.
    free = width - columns
    return [math.sqrt(float(np.median(left)) / free / (1.0 - 2.0 / (9.0 * free)) ** 3)]


def _waves(time: Array, frequency: float, harmonics: int) -> Array:
    """(n, columns): harmonics of a frequency in cycles per sample, with sizes that change as polynomials."""
    turns = 2.0 * math.pi * frequency * time[:, None] * np.arange(1, harmonics + 1)
    sizes = (time[:, None] / time[-1]) ** np.arange(_DEGREES)
    waves = np.concatenate([np.ones((time.size, 1)), np.cos(turns), np.sin(turns)], axis=1)
    return np.asarray((waves[:, :, None] * sizes[:, None, :]).reshape(time.size, -1))


def _level(y: Array, block: int, per_period: float) -> float:
    """Standard deviation of white samples whose means over so many of them have the differences of these means."""
    means = y[: y.size // block * block].reshape(-1, block).mean(axis=1)
    squares = np.diff(means, _ORDER) ** 2 / math.comb(2 * _ORDER, _ORDER) * block
    width = max(1, min(round(per_period / _CELLS), squares.size // 4))
    cells = squares[: squares.size // width * width].reshape(-1, width).mean(axis=1)
    moving = cells[cells > 0.0]  # a record that ends at rest says nothing there
    if not moving.size:
        return 0.0
    return math.sqrt(float(moving[moving < _BROKEN * np.median(moving)].mean()))


def _step(y: Array) -> float:
    """Size of an encoder's or a converter's step; 0 where samples are not multiples of one."""
    moves = np.abs(np.diff(y[:_LOOKED_AT]))
    moves = moves[moves > 1e-9 * max(float(np.abs(y).max()), 1e-300)]
    if not moves.size:
        return 0.0
    step = float(moves.min())
    counts = moves[moves < _FEW_STEPS * step] / step
    return step if float(np.quantile(np.abs(counts - np.round(counts)), 0.9)) < _OFF_STEP else 0.0
