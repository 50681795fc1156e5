"""One shot as the diagnosis takes it, and the grid of instants at which it is looked at."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.signal import firwin, kaiserord, upfirdn

from platform_daemon.estimation import RingDownRecord
from platform_daemon.estimation.arrays import Array

_START_S = 0.1  # looked at sample by sample: transients of the switch live there
_ENOUGH = 16_000  # samples per channel; shorter records are looked at sample by sample
_HARMONICS = 6.5  # pass band, in fundamentals
_GUARD = 9.0  # Nyquist frequency after decimation, in fundamentals
_RIPPLE_DB = 90.0


@dataclass(frozen=True)
class Shot:
    """A ring-down with its measured noise.

    Attributes:
        name: file and frame.
        record: RX samples, dm/dt or an angle.
        noise_sd: (channels,) of one sample, in the record's unit, at the signal's frequencies.
        sensitivity: (channels, 3) V/(A m^2/s), None if unknown; receiver effects act on volts.
        group: what was common to some shots and not to others (amplitude, pose); shots of one group repeat each other.
    """

    name: str
    record: RingDownRecord
    noise_sd: Array
    sensitivity: Array | None = None
    group: str = ""


@dataclass(frozen=True)
class Grid:
    """Instants t = i step_s, first <= i < last, of a piece of a record: every sample, or decimated by `factor`.

    taps: low-pass filter of the decimation; its pass band is flat to 1e-4 up to 6.5 fundamentals, so that the model
    need not be filtered.
    """

    factor: int
    first: int
    last: int
    taps: Array = field(default_factory=lambda: np.ones(1))

    @property
    def count(self) -> int:
        """Number of instants."""
        return self.last - self.first

    def of(self, samples: Array) -> Array:
        """The samples (channels, n) at these instants, (channels, count)."""
        if self.factor == 1:
            return samples[:, self.first : self.last]
        half = self.taps.size // 2
        begin = self.first * self.factor - half
        piece = samples[:, begin : (self.last - 1) * self.factor + half + 1]
        filtered = np.stack([upfirdn(self.taps, row, 1, self.factor) for row in piece])
        skip = (2 * half) // self.factor
        return np.asarray(filtered[:, skip : skip + self.count])


def grids_for(record: RingDownRecord, last: int, frequency_hz: float) -> tuple[Grid, ...]:
    """Grids that cover samples valid_from .. last-1: the start in full, the rest decimated if it is long.

    frequency_hz: of the fundamental.
    """
    first, rate = record.valid_from, record.sampling_rate_hz
    factor = min(int(rate / (2.0 * _GUARD * frequency_hz)), (last - first) // _ENOUGH)
    if factor < 2:
        return (Grid(1, first, last),)
    taps = _low_pass(rate, factor, frequency_hz)
    half = taps.size // 2
    begin = -(-max(first + half, round(_START_S * rate)) // factor)
    end = (last - half) // factor
    tail = max(end * factor, begin * factor)
    return Grid(1, first, begin * factor), Grid(factor, begin, end, taps), Grid(1, tail, last)


def _low_pass(rate_hz: float, factor: int, frequency_hz: float) -> Array:
    """Linear-phase taps; half their number is a multiple of the factor, so that instants fall on samples."""
    nyquist = 0.5 * rate_hz / factor
    width = 2.0 * (nyquist - _HARMONICS * frequency_hz)
    count, beta = kaiserord(_RIPPLE_DB, width / (0.5 * rate_hz))
    half = factor * -(-count // (2 * factor))
    return np.asarray(firwin(2 * half + 1, nyquist, window=("kaiser", beta), fs=rate_hz))
