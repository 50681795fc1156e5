"""Two resonators far from each other: two lines in the spectrum, of which none is a harmonic of the other.

Only for records that no fit gets through: what is left beside the harmonics of both must be little, so that a broken
record, whose spectrum is broad, is not taken for two lines.
"""

from __future__ import annotations

import numpy as np

from ..numerics.arrays import Array
from ..record import RingDownRecord
from .beat import Beat
from .frequency_search import block_means
from .spectral_lines import periodogram

_PERIODS = 60.0
_FEWEST_PERIODS = 15.0
_POINTS_PER_PERIOD = 24.0
_HIGHEST = 3.5  # times the stronger line's frequency, up to which lines are looked for
_LOBE_BINS = 3.5
_SWEEP = 0.03  # by which the frequency of a wide swing changes
_SMALLEST = 0.05  # of the stronger line
_HALF = 0.02
_LEFT = 0.05  # of the power, beside both


def find_far_lines(record: RingDownRecord, frequency_hz: float) -> Beat | None:
    """Two lines that are no harmonics of each other in the first sixty periods of about this frequency.

    Channels count alike: their noise, as it was measured beside one line, holds the other.
    """
    block = max(1, int(record.sampling_rate_hz / (frequency_hz * _POINTS_PER_PERIOD)))
    step = frequency_hz * block / record.sampling_rate_hz
    blocks = min((record.end - record.valid_from) // block, int(_PERIODS / step))
    if blocks * step < _FEWEST_PERIODS:
        return None
    means = block_means(record.samples, record.valid_from, block, blocks)
    power = periodogram(means - means.mean(axis=1, keepdims=True), np.blackman(blocks)).sum(axis=0)
    cycles = np.arange(power.size) / (blocks * step)  # in units of frequency_hz
    seen = (cycles > 2.0 * _LOBE_BINS / (blocks * step)) & (cycles < _HIGHEST)
    if not seen.any():
        return None
    first = float(cycles[np.argmax(np.where(seen, power, 0.0))])
    beside = seen & ~_harmonics(cycles, first, blocks * step)
    if not beside.any():
        return None
    second = float(cycles[np.argmax(np.where(beside, power, 0.0))])
    left = beside & ~_harmonics(cycles, second, blocks * step)
    ratio = float(np.sqrt(power[beside].max() / power[seen].max()))
    alone = power[left].sum() < _LEFT * power[beside].sum()
    # The stronger line may be the second harmonic itself.
    is_half = abs(first - 2.0 * second) < _HALF * first
    if ratio < _SMALLEST or is_half or not alone:
        return None
    return Beat((frequency_hz * first, frequency_hz * second), ratio)


def _harmonics(cycles: Array, line: float, periods: float) -> np.ndarray:
    """True where a line and its multiples stand, bool (bins,)."""
    order = np.maximum(np.round(cycles / line), 1.0)
    return np.abs(cycles - order * line) < _LOBE_BINS / periods + _SWEEP * order * line
