"""One shot with its noise, and the grid of instants on which it is compared with the model."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.signal import firwin, kaiserord, upfirdn

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.noise.angle import quietest_sd
from platform_daemon.estimation.noise.coloured import sd_at
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.rotor_fit.shot import RotorContext
from platform_daemon.estimation.screening.oscillation import find_oscillation

_LIMITS = THRESHOLDS.shots
_UNITS = {"dmdt": "A m^2/s", "voltage": "V", "angle": "rad"}


@dataclass(frozen=True)
class DiagnosisShot:
    """A ring-down with its measured noise.

    Attributes:
        name: file and frame.
        record: RX samples: dm/dt, an angle, or volts of coils whose sensitivities are every shot's own parameters.
        noise: of the record's channels.
        sensitivity: (channels, 3) V/(A m^2/s), None if unknown; receiver effects act on volts.
        group: what was common to some shots and not to others (amplitude, pose); shots of one group repeat each other.
        samples_in: unit of the record's samples where it is not that of its quantity: counts of a converter.
        rotor: what the recording says of the rotor and its drive; None: nothing, or not enough.
    """

    name: str
    record: RingDownRecord
    noise: NoiseModel
    sensitivity: Array | None = None
    group: str = ""
    samples_in: str = ""
    rotor: RotorContext | None = None

    @property
    def unit(self) -> str:
        """Of the record's samples."""
        return self.samples_in or _UNITS[self.record.quantity]

    @property
    def volts(self) -> str:
        """What the digitiser's samples are in: V, or counts."""
        return self.samples_in or "V"

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return self.record.sampling_rate_hz

    @cached_property
    def to_volts(self) -> Array:
        """(channels, channels): from the record's channels to those of the digitiser; identity if unknown."""
        return np.eye(self.record.channels) if self.sensitivity is None else -self.sensitivity

    @cached_property
    def from_volts(self) -> Array:
        """Back from the digitiser's channels."""
        return np.asarray(np.linalg.inv(self.to_volts), dtype=np.float64)


def as_measured(shot: DiagnosisShot) -> DiagnosisShot:
    """An angle with no less noise than a measured one can have; anything else as it is."""
    if shot.record.quantity != "angle" or (line := find_oscillation(shot.record)) is None:
        return shot
    sd = float(shot.noise.sd[0])
    least = quietest_sd(shot.record, sd, line.frequency_hz)
    return shot if least == sd else replace(shot, noise=NoiseModel.white(np.array([least]), shot.rate_hz))


@dataclass(frozen=True)
class SampleGrid:
    """Instants t = i factor / rate, first <= i < last, of a piece of a record: every sample, or decimated.

    taps: low-pass filter of the decimation; its pass band is flat to 1e-6 up to 6.5 fundamentals, so that the model
    need not be filtered.
    """

    factor: int
    first: int
    last: int
    taps: Array = field(default_factory=lambda: np.ones(1))

    @classmethod
    def every_sample(cls, record: RingDownRecord) -> SampleGrid:
        """All that are valid."""
        return cls(1, record.valid_from, record.valid_from + record.valid.shape[1])

    @property
    def count(self) -> int:
        """Number of instants."""
        return self.last - self.first

    @property
    def dof(self) -> float:
        """Expected sum of squares of white noise of unit density in its pass band: the filter takes a little."""
        return self.count * self.factor * float(np.sum(self.taps**2))

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


def grids_for(record: RingDownRecord, last: int, frequency_hz: float) -> tuple[SampleGrid, ...]:
    """Grids that cover samples valid_from .. last-1: the start in full, the rest decimated if it is long.

    frequency_hz: of the fundamental.  The decimating filter needs `half` samples on either side, so the end of the
    record, too, keeps the full rate.
    """
    first, rate = record.valid_from, record.sampling_rate_hz
    factor = min(int(rate / (2.0 * _LIMITS.nyquist * frequency_hz)), (last - first) // _LIMITS.full_rate_samples)
    if factor < 2:
        return (SampleGrid(1, first, last),)
    taps = _low_pass(rate, factor, frequency_hz)
    half = taps.size // 2
    begin = -(-max(first + half, first + round(_LIMITS.full_rate_s * rate)) // factor)
    end = (last - half) // factor
    if end - begin < _LIMITS.least_decimated:
        return (SampleGrid(1, first, last),)
    return SampleGrid(1, first, begin * factor), SampleGrid(factor, begin, end, taps), SampleGrid(1, end * factor, last)


def even_grid(record: RingDownRecord, frequency_hz: float) -> SampleGrid:
    """One grid of the valid samples, decimated by a filter so short that a quarter of a swing is lost at either end.

    frequency_hz: of the fundamental; a record hardly longer than the filter keeps every sample.
    """
    every = SampleGrid.every_sample(record)
    factor = int(record.sampling_rate_hz / (2.0 * _LIMITS.even_nyquist * frequency_hz))
    if factor < 2:
        return every
    taps = _low_pass(record.sampling_rate_hz, factor, frequency_hz)
    half = taps.size // 2
    first, last = -(-(every.first + half) // factor), (every.last - 1 - half) // factor + 1
    return SampleGrid(factor, first, last, taps) if last - first > taps.size else every


def band_sd(noise: NoiseModel, frequency_hz: float, rate_hz: float) -> Array:
    """Standard deviation (channels,) of white noise with the mean density of the first harmonics' band.

    frequency_hz: of the fundamental.
    """
    band = np.linspace(_LIMITS.level_band_from * frequency_hz, _LIMITS.pass_band * frequency_hz, _LIMITS.level_points)
    return np.asarray(np.sqrt(np.mean(sd_at(noise, band, rate_hz) ** 2, axis=1)))


def _low_pass(rate_hz: float, factor: int, frequency_hz: float) -> Array:
    """Linear-phase taps; half their number is a multiple of the factor, so that instants fall on samples."""
    nyquist = 0.5 * rate_hz / factor
    width = 2.0 * (nyquist - _LIMITS.pass_band * frequency_hz)
    count, beta = kaiserord(_LIMITS.ripple_db, width / (0.5 * rate_hz))
    half = factor * -(-count // (2 * factor))
    return np.asarray(firwin(2 * half + 1, nyquist, window=("kaiser", beta), fs=rate_hz))


@dataclass(frozen=True)
class Whitening:
    """Columns in units of the noise: scaled by its level at the signal, and filtered where it is not flat there.

    Attributes:
        slices: of every grid among the instants.
        scale: (channels, m) 1 / standard deviation.
        filters: per grid (channels, bins) on its Fourier transform, or None where scaling is enough.
    """

    slices: tuple[slice, ...]
    scale: Array
    filters: tuple[Array | None, ...]

    def __call__(self, columns: Array) -> Array:
        """(..., channels, m) -> (..., channels m)."""
        scaled = columns * self.scale
        for where, shape in zip(self.slices, self.filters, strict=True):
            if shape is not None:
                n = where.stop - where.start
                scaled[..., where] = np.fft.irfft(np.fft.rfft(scaled[..., where], axis=-1) * shape, n, axis=-1)
        return np.asarray(scaled.reshape(*columns.shape[:-2], -1))


def whitening_for(shot: DiagnosisShot, grids: tuple[SampleGrid, ...], frequency_hz: float) -> Whitening:
    """From the noise's level in the band of the first harmonics; frequency_hz: of the fundamental."""
    level = sd_at(shot.noise, np.array([frequency_hz]), shot.rate_hz)[:, 0]
    ends = np.cumsum([0, *(g.count for g in grids)])
    slices = tuple(slice(int(a), int(b)) for a, b in itertools.pairwise(ends))
    scale = np.concatenate([np.full(g.count, np.sqrt(g.factor)) for g in grids]) / level[:, None]
    return Whitening(slices, scale, tuple(_filter(shot, g, frequency_hz, level) for g in grids))


def _filter(shot: DiagnosisShot, grid: SampleGrid, frequency_hz: float, level: Array) -> Array | None:
    """Level at the fundamental over that at every bin, held beyond the harmonics; None for white noise."""
    low_hz, high_hz = _LIMITS.level_band_from * frequency_hz, _LIMITS.pass_band * frequency_hz
    band = np.geomspace(low_hz, high_hz, _LIMITS.level_points)
    levels = sd_at(shot.noise, band, shot.rate_hz) / level[:, None]
    if np.all(np.abs(levels - 1.0) < _LIMITS.white_share):
        return None
    bins = np.fft.rfftfreq(grid.count, grid.factor / shot.rate_hz)
    shape: NDArray[np.float64] = np.stack([1.0 / np.interp(bins, band, row) for row in levels])
    return shape


@dataclass(frozen=True)
class PreparedShot:
    """A shot with a fitted state of the declared model, its grids and how its noise is taken out of columns.

    bases: cache of basis functions of the last states, see `linearisation.basis_at`.
    """

    shot: DiagnosisShot
    state: FitState
    grids: tuple[SampleGrid, ...]
    white: Whitening
    bases: dict[tuple[object, ...], Array] = field(default_factory=dict, compare=False, repr=False)

    @property
    def dof(self) -> float:
        """Expected sum of squares of the whitened noise."""
        return self.shot.record.channels * sum(g.dof for g in self.grids)

    @cached_property
    def time_s(self) -> Array:
        """Of the instants, (m,); 0 at the first RX sample."""
        return np.concatenate([np.arange(g.first, g.last) * (g.factor / self.shot.rate_hz) for g in self.grids])

    def at_instants(self, samples: Array) -> Array:
        """Samples (channels, n) at the instants, (channels, m)."""
        return np.concatenate([g.of(samples) for g in self.grids], axis=1)

    @cached_property
    def data(self) -> Array:
        """The record at the instants, (channels, m)."""
        return self.at_instants(self.shot.record.samples)
