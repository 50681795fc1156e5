"""Noise of every channel, measured beside the signal: between and above its harmonics, never from a fit residual."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Array
from .oscillation import find_oscillation
from .record import RingDownRecord
from .spectrum import SegmentSpectra, segment_spectra

_SIGNIFICANT = 60.0
_MOST_HARMONICS = 24
_BRIDGEHEAD = 40  # bins at most, from which the level beside a gap is read
_SEGMENT_PERIODS = 28.0
_SEGMENT_WITHOUT_SIGNAL = 4096
_BROADENING = 1.25
_SWEEP_MARGIN = 0.01
_TINY = 1e-300


@dataclass(frozen=True)
class NoiseModel:
    """Noise of a record's channels.

    Attributes:
        sd: (channels,) standard deviation of one sample, in the record's unit.
        frequency_hz: (k,) grid of the spectrum.
        psd: (channels, k) one-sided power density, unit^2/Hz, interpolated across the harmonics of the signal.
    """

    sd: Array
    frequency_hz: Array
    psd: Array

    @classmethod
    def white(cls, sd: Array, sampling_rate_hz: float) -> NoiseModel:
        """Flat noise of known standard deviation (channels,)."""
        sd = np.asarray(sd, dtype=np.float64)
        grid = np.array([0.0, 0.5 * sampling_rate_hz])
        return cls(sd, grid, np.repeat((2.0 * sd**2 / sampling_rate_hz)[:, None], 2, axis=1))


def estimate_noise(record: RingDownRecord) -> NoiseModel:
    """Noise of a record, from all its valid samples.

    The averaged spectrum is read where the signal is not: harmonics are masked over the range their frequency
    sweeps through, as far up as they stand out, and the gaps are bridged. The variance is the integral.
    """
    samples, rate = record.valid, record.sampling_rate_hz
    line = find_oscillation(record)
    if line is None or line.significance < _SIGNIFICANT:
        spectra = segment_spectra(samples, rate, _SEGMENT_WITHOUT_SIGNAL)
        mask = np.zeros(spectra.frequency_hz.size, dtype=bool)
    else:
        spectra = segment_spectra(samples, rate, int(_SEGMENT_PERIODS * rate / line.frequency_hz))
        mask = _harmonic_mask(spectra, line.frequency_hz)
    density = spectra.density.mean(axis=0)
    # The lowest bins lack what the removal of the offset took from them.
    mask[:4] = True
    psd = np.stack([_bridge(spectra.frequency_hz, row, mask, spectra.density.shape[0]) for row in density])
    step = spectra.frequency_hz[1] - spectra.frequency_hz[0]
    sd = np.sqrt(np.sum(psd, axis=1) * step)
    return NoiseModel(np.asarray(sd), spectra.frequency_hz, psd)


def _harmonic_mask(spectra: SegmentSpectra, frequency_hz: float) -> np.ndarray:
    """True where the signal's harmonics may stand, bool (k,)."""
    low, high = _sweep_range(spectra, frequency_hz)
    grid = spectra.frequency_hz
    mask = np.zeros(grid.size, dtype=bool)
    total = spectra.density.mean(axis=0)
    reference = np.median(total[:, grid > 0.5 * grid[-1]], axis=1)
    # The decay and the sweep inside a segment broaden the line beyond the window's own lobe.
    margin = _BROADENING * spectra.lobe_hz
    quiet = 0
    for k in range(1, _MOST_HARMONICS + 1):
        zone = _folded_zone(grid, k * low - margin, k * high + margin)
        if not zone.any():
            break
        mask |= zone
        level = np.max(total[:, zone], axis=1)
        quiet = quiet + 1 if np.all(level < 4.0 * reference) else 0
        if quiet == 3:
            break
    return mask


def _folded_zone(grid: Array, low: float, high: float) -> np.ndarray:
    """Bins where content between low and high (Hz) appears, also by aliasing, bool (k,)."""
    rate = 2.0 * grid[-1]
    zone = np.zeros(grid.size, dtype=bool)
    for turns in range(int((high + grid[-1]) / rate) + 1):
        zone |= (turns * rate + grid > low) & (turns * rate + grid < high)
        zone |= (turns * rate - grid > low) & (turns * rate - grid < high)
    return zone


def _sweep_range(spectra: SegmentSpectra, frequency_hz: float) -> tuple[float, float]:
    """Range of the fundamental over the record: an amplitude-dependent frequency rises as the motion decays."""
    grid = spectra.frequency_hz
    window = (grid > 0.85 * frequency_hz) & (grid < 1.25 * frequency_hz)
    power = spectra.density.sum(axis=1)
    floor = np.median(power, axis=1)
    peaks = np.max(power[:, window], axis=1)
    where = grid[window][np.argmax(power[:, window], axis=1)]
    seen = where[peaks > 30.0 * floor]
    if seen.size == 0:
        return frequency_hz, frequency_hz
    low, high = min(frequency_hz, float(seen.min())), max(frequency_hz, float(seen.max()))
    return low * (1.0 - _SWEEP_MARGIN), high * (1.0 + _SWEEP_MARGIN)


def _bridge(grid: Array, density: Array, mask: np.ndarray, segments: int) -> Array:
    """Density with the masked bins replaced by the line between the levels of their neighbours.

    Levels are medians, so that a mains line beside the gap does not fill it; `segments` (overlapping) were averaged.
    """
    # Ratio of median to mean of an average of k exponentially distributed powers.
    k = 0.5 * (segments + 1)
    median_over_mean = 1.0 - 1.0 / (3.0 * k) + 0.0247 / k**2
    keep = ~mask
    if not keep.any():
        return np.full(grid.size, float(np.median(density)) / median_over_mean)
    out = density.copy()
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        width = min(max(12, end - begin), _BRIDGEHEAD)
        sides = slice(max(0, begin - width), begin), slice(end, end + width)
        medians = [float(np.median(density[side][keep[side]])) for side in sides if keep[side].any()]
        levels = [m / median_over_mean for m in medians] or [float(np.median(density[keep])) / median_over_mean]
        # Noise falls off like a power of frequency, if at all: bridge in the logarithm.
        out[begin:end] = np.geomspace(max(levels[0], _TINY), max(levels[-1], _TINY), end - begin)
    return out
