"""Noise of every channel, measured beside the signal: between and above its harmonics, not from a fit's residual.

Angles of few periods are the exception (OWN_RESIDUAL, OWN_FLOOR; goodness_of_fit/noise_floor.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar, cast

import numpy as np
from scipy.special import gammaincinv

from ..numerics.arrays import Array
from ..record import RingDownRecord
from ..screening.oscillation import find_oscillation
from .angle import angle_noise_sd
from .welch import SegmentSpectra, segment_spectra

_SIGNIFICANT = 60.0
_QUIETEST = 0.25  # share of the bins, by their level, that folded harmonics leave free
_STANDS_OUT = 3.7  # over the level of the noise
_FEWEST_BINS = 16  # beside the harmonics, that tell the level of the noise
_MOST_HARMONICS = 24
_BRIDGEHEAD = 40  # bins at most, from which the level beside a gap is read
_SEGMENT_PERIODS = 28.0
_SEGMENT_SAMPLES = 1024  # at least, where few samples a period fold all harmonics into a narrow band
_SEGMENT_WITHOUT_SIGNAL = 4096
_BROADENING = 1.25
_SWEEP_MARGIN = 0.01
_LOWEST_BINS = 4
_LINE_BINS = 6.5  # half width of a tone's line
_BY_CHANCE = 1e-6  # that noise alone is taken for a swing
_TINY = 1e-300
_MOST_KEPT = 256
OWN = "the record itself"
OWN_RESIDUAL = "the fit's white residual"
OWN_FLOOR = "the fit's residual above the harmonics"
OF_RECORD = (OWN, OWN_RESIDUAL, OWN_FLOOR)  # nobody measured it elsewhere
_T = TypeVar("_T")


@dataclass(frozen=True)
class NoiseModel:
    """Noise of a record's channels.

    Attributes:
        sd: (channels,) standard deviation of one sample, in the record's unit.
        frequency_hz: (k,) grid of the spectrum.
        psd: (channels, k) one-sided power density, unit^2/Hz, interpolated across the harmonics of the signal.
        degrees: (k,) independent complex values behind each bin, 0 where it was interpolated; None: known exactly.
        correlated_bins: so many neighbouring bins share one independent value.
        source: where it was measured.
        tones_hz: frequencies of steady tones that stood in it, and that sd and psd are without.
    """

    sd: Array
    frequency_hz: Array
    psd: Array
    degrees: Array | None = None
    correlated_bins: float = 1.0
    source: str = "given"
    tones_hz: tuple[float, ...] = ()
    _results: dict[Any, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    @classmethod
    def white(cls, sd: Array, sampling_rate_hz: float) -> NoiseModel:
        """Flat noise of known standard deviation (channels,)."""
        sd = np.asarray(sd, dtype=np.float64)
        grid = np.array([0.0, 0.5 * sampling_rate_hz])
        return cls(sd, grid, np.repeat((2.0 * sd**2 / sampling_rate_hz)[:, None], 2, axis=1))

    def kept(self, work: Callable[..., _T], *args: float) -> _T:
        """work(self, *args), never None, done once for all shots of a series that share this noise."""
        key = (work, *args)
        found = self._results.get(key)
        if found is None:
            if len(self._results) >= _MOST_KEPT:
                self._results.clear()
            found = self._results[key] = work(self, *args)
        return cast(_T, found)

    def at_level(self, ratio: float, source: str) -> NoiseModel:
        """The model with so many times its standard deviation, known from elsewhere."""
        return replace(self, sd=self.sd * ratio, psd=self.psd * ratio**2, source=source)

    def without_tones(self, tones_hz: Array) -> NoiseModel:
        """The model with what stands beside in place of the lines of steady tones (tones,)."""
        grid = self.frequency_hz
        if self.degrees is None or tones_hz.size == 0:
            return self
        return self._bridged(np.any(np.abs(grid - tones_hz[:, None]) < _LINE_BINS * grid[1], axis=0))

    def without_ringing(self, low_hz: float, high_hz: float) -> NoiseModel:
        """The model of a blank shot with what stands beside in place of a rotor that still swings between these
        frequencies, and of its harmonics; itself if none does."""
        if self.degrees is None:
            return self
        grid, rings = self.frequency_hz, np.zeros(self.frequency_hz.size, dtype=bool)
        margin = _LINE_BINS * grid[1]
        for k in range(1, _MOST_HARMONICS + 1):
            zone = (grid > k * low_hz - margin) & (grid < k * high_hz + margin)
            if not self._stands_out(zone):
                break
            rings |= zone
        return self._bridged(rings) if rings.any() else self

    def _stands_out(self, zone: np.ndarray) -> bool:
        """More power in these bins than those beside them allow, in any channel."""
        assert self.degrees is not None
        seen = zone & (self.degrees > 0.0)
        if not seen.any() or zone.all():
            return False
        beside = bridge(self.psd, zone | (self.degrees == 0.0), self.degrees)
        shape = float(np.median(self.degrees[seen]))
        # The largest of so many averages of exponentially distributed powers.
        most = gammaincinv(shape, 1.0 - _BY_CHANCE / (self.psd.shape[0] * np.count_nonzero(seen))) / shape
        return bool(np.any(self.psd[:, seen] > most * beside[:, seen]))

    def _bridged(self, gap: np.ndarray) -> NoiseModel:
        """The model with what stands beside in place of these bins."""
        assert self.degrees is not None
        degrees = np.where(gap, 0.0, self.degrees)
        # What was interpolated before may rest on a line: all gaps are bridged anew.
        psd = bridge(self.psd, degrees == 0.0, degrees)
        return replace(self, sd=sd_of(self.frequency_hz, psd), psd=psd, degrees=degrees)


def estimate_noise(record: RingDownRecord, *, blank: bool = False) -> NoiseModel:
    """Noise of a record, from all its valid samples; blank: it is known to hold no signal.

    The averaged spectrum is read where the signal is not: harmonics are masked over the range their frequency
    sweeps through, as far up as they stand out, and the gaps are bridged. The variance is the integral. An angle's is
    taken from differences of its samples (angle.py) wherever these are dense enough.
    """
    samples, rate = record.valid, record.sampling_rate_hz
    line = None if blank else find_oscillation(record)
    if record.quantity == "angle" and line is not None and line.significance >= _SIGNIFICANT:
        sd = angle_noise_sd(record, line.frequency_hz)
        if sd is not None:
            return replace(NoiseModel.white(np.full(record.channels, sd), rate), source=OWN)
    if line is None or line.significance < _SIGNIFICANT:
        spectra = segment_spectra(samples, rate, max(_SEGMENT_WITHOUT_SIGNAL, samples.shape[1] // 8))
        mask = np.zeros(spectra.frequency_hz.size, dtype=bool)
    else:
        segment = max(int(_SEGMENT_PERIODS * rate / line.frequency_hz), min(_SEGMENT_SAMPLES, samples.shape[1] // 2))
        spectra = segment_spectra(samples, rate, segment)
        mask = _harmonic_mask(spectra, line.frequency_hz)
    # The lowest bins lack what the removal of the offset took from them.
    mask[:_LOWEST_BINS] = True
    each, density = np.full(mask.size, spectra.degrees), spectra.density.mean(axis=0)
    mask |= np.count_nonzero(~mask) < _FEWEST_BINS
    psd = _flat(density, spectra.degrees) if mask.all() else bridge(density, mask, each)
    grid, degrees = spectra.frequency_hz, np.where(mask, 0.0, each)
    return NoiseModel(sd_of(grid, psd), grid, psd, degrees, spectra.correlated_bins, OWN)


def _flat(density: Array, degrees: float) -> Array:
    """Flat noise (channels, k), where harmonics may stand in every bin."""
    level = np.maximum(_quiet_level(density[:, _LOWEST_BINS:], degrees), _TINY)
    return np.repeat(level[:, None], density.shape[1], axis=1)


def _quiet_level(density: Array, degrees: float) -> Array:
    """Level of the noise, (channels,), from the quietest of the bins (channels, k).

    Right where harmonics fill none of them; where they fill half, it tells a sixth too much (as a deviation).
    """
    share = float(gammaincinv(degrees, _QUIETEST)) / degrees
    return np.asarray(np.quantile(density, _QUIETEST, axis=1) / share)


def sd_of(grid: Array, psd: Array) -> Array:
    """Standard deviations (channels,) of noise with this density."""
    return np.asarray(np.sqrt(np.sum(psd, axis=1) * (grid[1] - grid[0])))


def _harmonic_mask(spectra: SegmentSpectra, frequency_hz: float) -> np.ndarray:
    """True where the signal's harmonics may stand, bool (k,)."""
    low, high = _sweep_range(spectra, frequency_hz)
    grid = spectra.frequency_hz
    mask = np.zeros(grid.size, dtype=bool)
    total = spectra.density.mean(axis=0)
    reference = _quiet_level(total[:, grid > 0.5 * grid[-1]], spectra.degrees)
    # The decay and the sweep inside a segment broaden the line beyond the window's own lobe.
    margin = _BROADENING * spectra.lobe_hz
    quiet = 0
    for k in range(1, _MOST_HARMONICS + 1):
        zone = _folded_zone(grid, k * low - margin, k * high + margin)
        if not zone.any():
            break
        mask |= zone
        level = np.max(total[:, zone], axis=1)
        quiet = quiet + 1 if np.all(level < _STANDS_OUT * reference) else 0
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
    if not window.any():
        return frequency_hz, frequency_hz
    power = spectra.density.sum(axis=1)
    floor = np.median(power.mean(axis=0))
    peaks = np.max(power[:, window], axis=1)
    where = grid[window][np.argmax(power[:, window], axis=1)]
    seen = where[peaks > 30.0 * floor]
    if seen.size == 0:
        return frequency_hz, frequency_hz
    low, high = min(frequency_hz, float(seen.min())), max(frequency_hz, float(seen.max()))
    return low * (1.0 - _SWEEP_MARGIN), high * (1.0 + _SWEEP_MARGIN)


def bridge(psd: Array, mask: np.ndarray, degrees: Array) -> Array:
    """Densities (channels, k) with the masked bins replaced by the line between the levels of their neighbours.

    Levels are medians, so that a mains line beside the gap does not fill it; `degrees` (k,) as in NoiseModel.
    """
    keep = ~mask
    out = psd.copy()
    if not keep.any():
        out[:] = np.median(psd, axis=1, keepdims=True)
        return out
    for begin, end, seen in gaps(keep):
        left, right = (_levels(psd[:, s][:, keep[s]], degrees[s][keep[s]]) for s in (seen[0], seen[-1]))
        # Noise falls off like a power of frequency, if at all: bridge in the logarithm.
        slope = np.log(right / left) / max(end - begin - 1, 1)
        out[:, begin:end] = left[:, None] * np.exp(np.outer(slope, np.arange(end - begin)))
    return out


def gaps(keep: np.ndarray) -> Iterator[tuple[int, int, list[slice]]]:
    """Runs begin .. end-1 of bins that are not kept, and the neighbours on either side that stand for them."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (~keep).astype(np.int8), [0]]))).tolist()
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        width = min(max(12, end - begin), _BRIDGEHEAD)
        sides = [slice(max(0, begin - width), begin), slice(end, end + width)]
        yield begin, end, [side for side in sides if keep[side].any()] or [slice(0, keep.size)]


def _levels(density: Array, degrees: Array) -> Array:
    """Mean density per channel from the medians of some bins, (channels,)."""
    # Ratio of median to mean of an average of k exponentially distributed powers.
    k = max(float(degrees[0]), 1.0)
    return np.asarray(np.maximum(np.median(density, axis=1) / (1.0 - 1.0 / (3.0 * k) + 0.0247 / k**2), _TINY))
