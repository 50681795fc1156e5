"""Noise of an angle: from high differences of its samples, because an oscillation is smooth and noise is not.

Between the few harmonics of a swing that decays over many periods is the leakage of the swing itself, which is larger
than the noise of any encoder. Differences of a high order between neighbouring samples, and between means of
neighbouring samples, hold nothing of a smooth motion. They show the noise from half the sampling rate down to some
ten times the swing's frequency; steps of an encoder that is read more often than it counts are slow, so the scale
where it is largest counts.

Filters, splines and integration leave hardly any noise there, although some is left near the swing. Such an angle
becomes rougher towards longer scales, by more than a motion does. Its noise is at least what is no sum of harmonics
of slowly changing size in windows of few periods.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import gammaincinv

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.noise


def angle_noise_sd(record: RingDownRecord, frequency_hz: float) -> float | None:
    """Standard deviation of a sample, were the noise white at its level near the swing's harmonics, in rad.

    None if there are too few samples per period, or too few at all, to tell noise from motion.
    """
    y, rate = record.valid[0], record.sampling_rate_hz
    levels: list[float] = []
    block, fewest = 1, LIMITS.difference_samples_per_period
    while (
        rate / (block * frequency_hz) >= fewest
        and y.size // block >= LIMITS.fewest_differences + LIMITS.difference_order
    ):
        level = _level(y, block, rate / (block * frequency_hz))
        if levels and level > LIMITS.motion_rise * max(levels[-1], _step(y) / math.sqrt(12.0)):
            break
        levels.append(level)
        block, fewest = 2 * block, LIMITS.difference_means_per_period
    if not levels:
        levels = _beside_waves(y, rate / frequency_hz)
    if not levels:
        return None
    level = max(*levels, _step(y) / math.sqrt(12.0))
    return max(level, *_slow(y, rate / frequency_hz)) if _is_smoothed(y, rate / frequency_hz, level) else level


def quietest_sd(record: RingDownRecord, sd: float, frequency_hz: float) -> float:
    """The standard deviation of an angle's noise if it was measured: one below any converter's is replaced.

    A filter that ends little above the swing may leave no other trace of itself than such a silence; what windows of
    few periods leave is then the least that the noise can be. A simulated angle without noise looks alike.
    """
    y = record.valid[0]
    if sd >= LIMITS.quietest_share * float(np.std(y)):
        return sd
    return max(sd, *_slow(y, record.sampling_rate_hz / frequency_hz), 0.0)


def _is_smoothed(y: Array, per_period: float, level: float) -> bool:
    """True where the noise near the swing is far above the level that differences of the samples show."""
    size = float(np.std(y))
    block, coarsest = 1, max(1, int(per_period / LIMITS.smooth_means_per_period))
    while block <= coarsest and y.size // block >= LIMITS.fewest_differences:
        least = max(LIMITS.smoothed_ratio * level, LIMITS.smooth_motion_share * math.sqrt(block) * size)
        if _usual_level(y, block) > least:
            return True
        block = min(2 * block, coarsest) if block < coarsest else coarsest + 1
    return False


def _slow(y: Array, per_period: float) -> list[float]:
    """The level near and above the harmonics of the swing, from means of few samples per period; none if too short."""
    block = max(1, int(per_period / LIMITS.wave_means_per_period))
    means = y[: y.size // block * block].reshape(-1, block).mean(axis=1)
    return [math.sqrt(block) * level for level in _beside_waves(means, per_period / block)]


def _usual_level(y: Array, block: int) -> float:
    """As _level, from the median of the squares: a kink at each turning point is in less than half of them."""
    means = y[: y.size // block * block].reshape(-1, block).mean(axis=1)
    squares = np.diff(means, LIMITS.difference_order) ** 2 * block
    usual = float(np.median(squares)) / float(gammaincinv(0.5, 0.5)) / 2.0  # of one degree of freedom
    return math.sqrt(usual / math.comb(2 * LIMITS.difference_order, LIMITS.difference_order))


def _beside_waves(y: Array, per_period: float) -> list[float]:
    """The level of what is no sum of harmonics of slowly changing size in windows of few periods; none if too few.

    For records with few samples per period, whose differences hold the swing itself.
    """
    width = round(LIMITS.wave_periods * per_period)
    harmonics = min(LIMITS.wave_harmonics, int(LIMITS.wave_highest_share * per_period))
    columns = LIMITS.wave_degrees * (2 * harmonics + 1)
    if harmonics < 2 or width < columns + LIMITS.wave_free_samples or y.size < 2 * width:
        return []
    starts = range(0, y.size - width + 1, width // 2)
    time = np.asarray(np.arange(width) - 0.5 * (width - 1), dtype=np.float64)
    left = np.full(len(starts), np.inf)
    windows = np.stack([y[k : k + width] for k in starts], axis=1)
    for share in LIMITS.wave_detuned:  # a large swing is slower than a small one
        q = np.linalg.qr(_waves(time, share / per_period, harmonics))[0]
        rest = windows - q @ (q.T @ windows)
        left = np.minimum(left, np.sum(rest**2, axis=0))
    # A kick or a jump is in few windows; of chi^2 the median is a little below the mean.
    free = width - columns
    return [math.sqrt(float(np.median(left)) / free / (1.0 - 2.0 / (9.0 * free)) ** 3)]


def _waves(time: Array, frequency: float, harmonics: int) -> Array:
    """(n, columns): harmonics of a frequency in cycles per sample, with sizes that change as polynomials."""
    turns = 2.0 * math.pi * frequency * time[:, None] * np.arange(1, harmonics + 1)
    sizes = (time[:, None] / time[-1]) ** np.arange(LIMITS.wave_degrees)
    waves = np.concatenate([np.ones((time.size, 1)), np.cos(turns), np.sin(turns)], axis=1)
    return np.asarray((waves[:, :, None] * sizes[:, None, :]).reshape(time.size, -1))


def _level(y: Array, block: int, per_period: float) -> float:
    """Standard deviation of white samples whose means over so many of them have the differences of these means."""
    means = y[: y.size // block * block].reshape(-1, block).mean(axis=1)
    squares = (
        np.diff(means, LIMITS.difference_order) ** 2
        / math.comb(2 * LIMITS.difference_order, LIMITS.difference_order)
        * block
    )
    width = max(1, min(round(per_period / LIMITS.cells_per_period), squares.size // LIMITS.fewest_cells))
    cells = squares[: squares.size // width * width].reshape(-1, width).mean(axis=1)
    moving = cells[cells > 0.0]  # a record that ends at rest says nothing there
    if not moving.size:
        return 0.0
    return math.sqrt(float(moving[moving < LIMITS.broken_power * np.median(moving)].mean()))


def _step(y: Array) -> float:
    """Size of an encoder's or a converter's step; 0 where samples are not multiples of one."""
    moves = np.abs(np.diff(y[: LIMITS.step_samples]))
    moves = moves[moves > LIMITS.no_move_share * max(float(np.abs(y).max()), 1e-300)]
    if not moves.size:
        return 0.0
    step = float(moves.min())
    counts = moves[moves < LIMITS.few_steps * step] / step
    return (
        step
        if float(np.quantile(np.abs(counts - np.round(counts)), LIMITS.on_step_share)) < LIMITS.off_step_share
        else 0.0
    )
