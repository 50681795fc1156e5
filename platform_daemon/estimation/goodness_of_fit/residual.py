"""What a fit leaves over: its residual as block means in units of the noise, how white it is, and where it is largest.

The noise's own level is not trusted here: what contaminates a record also raises the noise measured beside the
signal. Whiteness compares the residual with itself, bin by bin and stretch by stretch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from statistics import median

import numpy as np
from scipy.fft import prev_fast_len, rfft

from platform_daemon.estimation.noise.model import OF_RECORD, NoiseModel
from platform_daemon.estimation.numerics.arrays import Array, IntArray, medians
from platform_daemon.estimation.numerics.jit import fast_kernel
from platform_daemon.estimation.thresholds import THRESHOLDS

from .noise_floor import NoiseFloor

LIMITS = THRESHOLDS.goodness_of_fit

_EULER = 0.57721566490153286  # -mean of the logarithm of an exponentially distributed power
_FLATNESS_SD = math.sqrt(math.pi**2 / 6.0 - 1.0)  # of the logarithm of the flatness, times sqrt(bins)


@dataclass(frozen=True, kw_only=True)
class Residual:
    """Block means of the residual.

    Attributes:
        data, model: (channels, blocks) block means in the record's unit, offsets taken off the data.
        sd: (channels,) standard deviation of the noise of one block mean, were it white.
        rate_hz: blocks per second.
        start_s: middle of the first block.
        noise: its spectrum says what is only colour.
        floor: of an angle: the noise that its residual shows, where it can be measured.
        widening: so many times the variances that the noise explains, by what the floor shows.
    """

    data: Array
    model: Array
    sd: Array
    rate_hz: float
    start_s: float
    noise: NoiseModel
    floor: NoiseFloor | None = None
    widening: float = 1.0

    @cached_property
    def scaled(self) -> Array:
        """Residual over noise, (channels, blocks)."""
        return np.asarray((self.data - self.model) / self.sd[:, None])

    def beginning(self, n: int) -> Residual:
        """The first n blocks."""
        return replace(self, data=self.data[:, :n], model=self.model[:, :n])

    @property
    def transformed(self) -> Array:
        """As much of `scaled` as the spectrum was made from, (channels, n)."""
        return self.scaled[:, : self._length]

    @property
    def _length(self) -> int:
        """Blocks that a fast transform takes."""
        return int(prev_fast_len(self.data.shape[1], real=True))

    @cached_property
    def _seen(self) -> tuple[Array, Array, Array]:
        """Power of the residual and the same over the density of the noise, (channels, bins); flatness (channels,)."""
        n = self._length
        bins = rfft(self.transformed, axis=1)[:, 1 : (n + 1) // 2]
        out = np.empty(bins.shape), np.empty(bins.shape), np.empty(bins.shape[0])
        _look(bins, 1.0 / n, self._colour, *out)
        return out

    @property
    def _power(self) -> Array:
        return self._seen[0]

    @property
    def with_lines(self) -> Array:
        """The spectrum in which steady lines show: noise of the record itself has them in its colour."""
        return self._power if self.noise.source in OF_RECORD else self.spectrum

    @property
    def spectrum(self) -> Array:
        """Power of the residual over the density of the noise, (channels, bins), without the bin of the offset."""
        return self._seen[1]

    @property
    def flatness(self) -> Array:
        """Spectral flatness per channel, (channels,): geometric over arithmetic mean of the power; noise only: 1."""
        return self._seen[2]

    @cached_property
    def _colour(self) -> Array:
        return self.noise.kept(_colour, self._length, self.rate_hz)

    @property
    def colour_sigma(self) -> float:
        """By how many standard deviations the least flat channel departs from white."""
        bins = self.spectrum.shape[1]
        return -math.log(max(self.flatness.min(), 1e-300)) * math.sqrt(bins) / _FLATNESS_SD

    @property
    def _level(self) -> Array:
        """Power of the noise, (channels,), by the median of the spectrum; of an angle (few bins) by its floor."""
        if self.floor is not None:
            return np.asarray((self.floor.sd(self.rate_hz) / self.sd) ** 2)
        return np.asarray(medians(self.spectrum) / math.log(2.0) * self._colour.mean(axis=1))

    @cached_property
    def unexplained(self) -> float:
        """Power left over beyond the noise that the residual's spectrum shows, relative to the model's power."""
        excess = np.maximum(self._power.mean(axis=1) - self._level, 0.0) * self.sd**2
        return float(excess.sum() / max(np.mean(self.model**2, axis=1).sum(), 1e-300))

    @property
    def is_rounding(self) -> bool:
        """True if so little is left over that it is the digits of the motion, and says nothing."""
        left = self.data - self.model
        return float(np.vdot(left, left)) < LIMITS.rounding_share**2 * float(np.vdot(self.model, self.model))

    @property
    def surplus(self) -> float:
        """Power beyond the noise, summed over the channels, in units of the noise."""
        return float(np.sum(np.mean(self.scaled**2, axis=1) - 1.0))

    @cached_property
    def line_power(self) -> float:
        """Power of the strongest line of any channel, relative to the model's; 0: none exceeds its spectrum."""
        blocks = self.data.shape[1]
        share = 2.0 / self._length * blocks / max(float(np.vdot(self.model, self.model)), 1e-300)
        # Hardly any record gets beyond this cheap bound.
        if float(self._power.max()) * max(self.sd.tolist()) ** 2 * share < LIMITS.weak_line_share:
            return 0.0
        lines = self._power.max(axis=1) * self.sd**2 * share
        lines[self._power.max(axis=1) < LIMITS.line_over_median * medians(self._power)] = 0.0
        return float(lines.max())

    @property
    def excess(self) -> float:
        """Chi^2 of the block means that significantly exceeds the noise that the residual's spectrum shows."""
        beyond = float(np.maximum(self._power.mean(axis=1) - self._level, 0.0).sum()) * self.scaled.shape[1]
        return max(0.0, beyond - LIMITS.power_sigma * math.sqrt(2.0 * self.scaled.size))

    @cached_property
    def coloured(self) -> bool:
        """True if a channel's residual is beyond doubt not white, at any level."""
        if self.floor is not None and (self.floor.sure or self.noise.source in OF_RECORD):
            # Between few harmonics the colour of an angle's noise is not known.
            return self.floor.sure and not self.is_rounding
        return self.colour_sigma > LIMITS.colour_sigma and float(self.flatness.min()) < LIMITS.flatness

    def outburst(self) -> tuple[float, float, float]:
        """(time in s, share of all power, significance in sd) of the stretch with the most power."""
        length = max(1, self.scaled.shape[1] // LIMITS.burst_stretches)
        count = self.scaled.shape[1] // length
        pieces = self.scaled[:, : count * length].reshape(-1, count, length)
        powers = np.einsum("ckl,ckl->k", pieces, pieces).tolist()
        largest, usual = max(powers), max(median(powers), 1e-300)
        sd = usual * math.sqrt(2.0 / (length * self.scaled.shape[0]))
        middle = self.start_s + (powers.index(largest) + 0.5) * length / self.rate_hz
        return middle, largest / sum(powers), (largest - usual) / sd


@fast_kernel
def _look(bins, share, colour, power, spectrum, flatness):  # type: ignore[no-untyped-def]
    """Write what Residual._seen holds, from complex bins (channels, m); colour (channels, m), or (channels, 1)."""
    m = bins.shape[1]
    for channel in range(bins.shape[0]):
        total = logarithms = 0.0
        for i in range(m):
            here = bins[channel, i]
            power[channel, i] = share * (here.real * here.real + here.imag * here.imag)
            spectrum[channel, i] = power[channel, i] / colour[channel, min(i, colour.shape[1] - 1)]
            total += spectrum[channel, i]
            logarithms += math.log(max(spectrum[channel, i], 1e-300))
        flatness[channel] = math.exp(logarithms / m + _EULER) / max(total / m, 1e-300)


def _colour(noise: NoiseModel, length: int, rate_hz: float) -> Array:
    """Density of the noise in wide bands, (channels, bins), up to a factor per channel: lines do not count.

    length: of the transform, whose bin of the offset is left out.
    """
    if noise.frequency_hz.size <= 2:
        return np.ones((noise.psd.shape[0], 1))
    centres, levels = noise.kept(_bands)
    frequency_hz = np.arange(1, (length + 1) // 2) * rate_hz / length
    smooth = np.stack([np.interp(frequency_hz, centres, row) for row in levels])
    return np.asarray(np.exp(smooth - smooth.mean(axis=1, keepdims=True)))


def _bands(noise: NoiseModel) -> tuple[Array, Array]:
    """Middles (m,) in Hz of wide bands and the mean logarithm of the density in them, (channels, m).

    Interpolated bins are left out; a band holds enough of the others for its mean to be no chance.
    """
    grid, degrees = noise.frequency_hz, noise.degrees
    independent = np.full(grid.size, LIMITS.known_degrees) if degrees is None else degrees / noise.correlated_bins
    seen = np.flatnonzero(independent > 0.0)
    if seen.size == 0:
        return grid[:1], np.zeros((noise.psd.shape[0], 1))
    edges = _edges(seen, independent[seen], grid.size)
    counts = np.diff(np.append(edges, seen.size))
    levels = np.add.reduceat(np.log(np.maximum(noise.psd[:, seen], 1e-300)), edges, axis=1) / counts
    return np.add.reduceat(grid[seen], edges) / counts, levels


def _edges(seen: IntArray, independent: Array, bins: int) -> IntArray:
    """Where bands begin in a list of bins, seen (k,), each with `independent` (k,) values."""
    octaves = max(1.0, math.log2(bins / LIMITS.colour_first_bins))
    limits = np.searchsorted(
        seen,
        np.geomspace(LIMITS.colour_first_bins, bins, int(LIMITS.colour_bands_per_octave * octaves)).astype(int)[:-1],
    ).tolist()
    sums = np.concatenate([[0.0], np.cumsum(independent)]).tolist()
    edges = [0]
    for limit in limits:
        if (
            sums[limit] - sums[edges[-1]] >= LIMITS.colour_band_values
            and sums[-1] - sums[limit] >= LIMITS.colour_band_values
        ):
            edges.append(limit)
    return np.array(edges)
