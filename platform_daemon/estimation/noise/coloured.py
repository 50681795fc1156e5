"""The noise that counts: its level at the signal's harmonics, as far as it differs significantly from white noise.

A spectrum from one short record is uncertain by tens of per cent per bin. Bins are therefore gathered into bands, and
a smooth law in the logarithm of the frequency is drawn through them; where neither the law nor the bands differ
significantly from the level of white noise, that level is used, so that white noise costs nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import digamma, polygamma

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.thresholds import THRESHOLDS

from .model import NoiseModel

LIMITS = THRESHOLDS.noise


@dataclass(frozen=True)
class _Bands:
    """Mean densities of bands of bins.

    Attributes:
        frequency_hz: (m,).
        log_density: (channels, m), unbiased for the logarithm of the expected density.
        weight: (m,) inverse variances of log_density.
    """

    frequency_hz: Array
    log_density: Array
    weight: Array


_NO_BANDS = _Bands(np.empty(0), np.empty((0, 0)), np.empty(0))


def sd_at(noise: NoiseModel, frequency_hz: Array, sampling_rate_hz: float) -> Array:
    """Standard deviation of white noise with the density at each frequency (m,): (channels, m)."""
    frequency_hz = np.asarray(frequency_hz, dtype=np.float64)
    if noise.degrees is None:
        density = np.stack([np.interp(frequency_hz, noise.frequency_hz, row) for row in noise.psd])
        return np.asarray(np.sqrt(0.5 * sampling_rate_hz * density))
    out = np.repeat(noise.sd[:, None], frequency_hz.size, axis=1)
    bands, coloured = _near(noise, float(frequency_hz.min()), sampling_rate_hz)
    for channel in coloured:
        law = _law(bands, bands.log_density[channel], np.log(frequency_hz))
        out[channel] = np.sqrt(0.5 * sampling_rate_hz * np.exp(law))
    return out


def is_white(noise: NoiseModel, frequency_hz: float, sampling_rate_hz: float) -> bool:
    """True if measured noise is as good as white around this frequency and its harmonics, in all channels."""
    return noise.degrees is not None and not _near(noise, frequency_hz, sampling_rate_hz)[1]


def _near(noise: NoiseModel, frequency_hz: float, sampling_rate_hz: float) -> tuple[_Bands, tuple[int, ...]]:
    """Bands and coloured channels; the shots of a series differ little in frequency: the same serve all of them."""
    near = 2.0 ** (round(LIMITS.law_steps_per_octave * math.log2(frequency_hz)) / LIMITS.law_steps_per_octave)
    return noise.kept(_coloured, near, sampling_rate_hz)


def _coloured(noise: NoiseModel, frequency_hz: float, sampling_rate_hz: float) -> tuple[_Bands, tuple[int, ...]]:
    """Bands around a frequency and its harmonics, and the channels in which they are not white."""
    bands = _bands(noise, frequency_hz / LIMITS.law_below, frequency_hz * LIMITS.law_above)
    if bands is None:
        return _NO_BANDS, ()
    excess = bands.log_density - np.log(2.0 * noise.sd**2 / sampling_rate_hz)[:, None]
    return bands, tuple(k for k, row in enumerate(excess) if not _is_white(row, bands.weight))


def _bands(noise: NoiseModel, low_hz: float, high_hz: float) -> _Bands | None:
    """Bands between two frequencies from the bins that were measured; None if they are too few for any statement."""
    grid, degrees = noise.frequency_hz, noise.degrees
    assert degrees is not None
    usable = np.flatnonzero((degrees > 0.0) & (grid > low_hz) & (grid < high_hz))
    share = degrees[usable]
    begins = _band_begins(grid[usable], np.cumsum(share) / noise.correlated_bins)
    if len(begins) <= LIMITS.law_power + 1:
        return None
    total = np.add.reduceat(share, begins)
    density = np.add.reduceat(share * noise.psd[:, usable], begins, axis=1) / total
    k = total / noise.correlated_bins
    middle = np.exp(np.add.reduceat(share * np.log(grid[usable]), begins) / total)
    log_density = np.log(np.maximum(density, 1e-300)) - (digamma(k) - np.log(k))
    return _Bands(middle, log_density, 1.0 / polygamma(1, k))


def _band_begins(grid: Array, independent: Array) -> list[int]:
    """First bins of bands that are as wide as the band ratio, or as it takes for enough independent values."""
    if grid.size == 0:
        return []
    octave = np.floor(np.log(grid / grid[0]) / np.log(LIMITS.band_ratio))
    begins, before = [0], 0.0
    for k in np.flatnonzero(np.diff(octave)):
        if min(independent[k] - before, independent[-1] - independent[k]) >= LIMITS.band_values:
            begins.append(int(k) + 1)
            before = float(independent[k])
    return begins


def _is_white(excess: Array, weight: Array) -> bool:
    """No significant difference of the bands (m,) from the level of white noise, in the mean, the trend, or at all."""
    mean = float(weight @ excess) / np.sqrt(weight.sum())
    squares, m = float(weight @ excess**2), excess.size
    halves = np.array_split(weight * excess, 3), np.array_split(weight, 3)
    thirds = [abs(a.sum()) / np.sqrt(b.sum()) for a, b in zip(*halves, strict=True)]
    return max(abs(mean), *thirds) < LIMITS.colour_sigma and squares < m + LIMITS.colour_sigma * np.sqrt(2.0 * m)


def _law(bands: _Bands, row: Array, log_frequency: Array) -> Array:
    """Logarithm of a channel's density at the frequencies, (m,): a polynomial in log f of no higher power than needed.

    Noise with edges follows no such law; there the bands beside each frequency are averaged.
    """
    x = np.log(bands.frequency_hz)
    root = np.sqrt(bands.weight)
    powers = np.arange(LIMITS.law_power + 1)
    q, r = np.linalg.qr(root[:, None] * (x - x[0])[:, None] ** powers)
    found = q.T @ (root * row)
    left = float(np.sum((root * row - q @ found) ** 2))
    freedom = row.size - powers.size
    if left > freedom + LIMITS.colour_sigma * np.sqrt(2.0 * freedom) + LIMITS.colour_sigma:
        return np.array([_beside(x - at, row, bands.weight) for at in log_frequency])
    found[np.abs(found) < np.where(powers > 0, LIMITS.law_power_sigma, 0.0)] = 0.0
    return np.asarray((log_frequency - x[0])[:, None] ** powers @ np.linalg.solve(r, found))


def _beside(distance: Array, row: Array, weight: Array) -> float:
    """Mean of the bands near distance 0, or the nearest one."""
    near = np.abs(distance) < np.log(LIMITS.beside_ratio)
    if not near.any():
        return float(row[np.argmin(np.abs(distance))])
    return float(weight[near] @ row[near] / weight[near].sum())
