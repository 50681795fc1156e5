"""Two resonators far from each other: two lines in the spectrum, of which none is a harmonic of the other.

Only for records that no fit gets through: little power may be left between the harmonics of both, so that a broken
record, whose spectrum is broad, is not taken for two lines.
"""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.thresholds import THRESHOLDS

from .beat import Beat
from .frequency_search import block_means
from .spectral_lines import periodogram

LIMITS = THRESHOLDS.screening


def find_far_lines(record: RingDownRecord, frequency_hz: float) -> Beat | None:
    """Two lines that are no harmonics of each other in the first sixty periods of about this frequency.

    All channels have the same weight: the noise measured beside one line holds the other line.
    """
    block = max(1, int(record.sampling_rate_hz / (frequency_hz * LIMITS.far_line_points_per_period)))
    step = frequency_hz * block / record.sampling_rate_hz
    blocks = min((record.end - record.valid_from) // block, int(LIMITS.far_line_periods / step))
    if blocks * step < LIMITS.far_line_fewest_periods:
        return None
    means = block_means(record.samples, record.valid_from, block, blocks)
    power = periodogram(means - means.mean(axis=1, keepdims=True), np.blackman(blocks)).sum(axis=0)
    cycles = np.arange(power.size) / (blocks * step)  # in units of frequency_hz
    seen = (cycles > 2.0 * LIMITS.far_line_lobe_bins / (blocks * step)) & (cycles < LIMITS.far_line_highest)
    if not seen.any():
        return None
    first = float(cycles[np.argmax(np.where(seen, power, 0.0))])
    beside = seen & ~_harmonics(cycles, first, blocks * step)
    if not beside.any():
        return None
    second = float(cycles[np.argmax(np.where(beside, power, 0.0))])
    left = beside & ~_harmonics(cycles, second, blocks * step)
    ratio = float(np.sqrt(power[beside].max() / power[seen].max()))
    alone = power[left].sum() < LIMITS.far_line_left_share * power[beside].sum()
    # The stronger line may be the second harmonic itself.
    is_half = abs(first - 2.0 * second) < LIMITS.far_line_half_share * first
    if ratio < LIMITS.far_line_smallest_ratio or is_half or not alone:
        return None
    return Beat(frequencies_hz=(frequency_hz * first, frequency_hz * second), ratio=ratio)


def _harmonics(cycles: Array, line: float, periods: float) -> np.ndarray:
    """True at a line and its multiples, bool (bins,)."""
    order = np.maximum(np.round(cycles / line), 1.0)
    return (
        np.abs(cycles - order * line) < LIMITS.far_line_lobe_bins / periods + LIMITS.far_line_sweep_share * order * line
    )
