"""Noise of every channel, measured between and above the harmonics of the signal, not from a fit's residual.

Angles of few periods are the exception (OWN_RESIDUAL, OWN_FLOOR; goodness_of_fit/noise_floor.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar, cast

import numpy as np
from scipy.special import gammaincinv

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.oscillation import find_oscillation
from platform_daemon.estimation.thresholds import THRESHOLDS

from .angle import angle_noise_sd
from .welch import SegmentSpectra, segment_spectra

LIMITS = THRESHOLDS.noise

_TINY = 1e-300
_MEDIAN_VARIANCE = 0.5 * math.pi  # of a median of powers, over that of their mean
OWN = "the record itself"
OWN_RESIDUAL = "the fit's white residual"
OWN_FLOOR = "the fit's residual above the harmonics"
OF_RECORD = (OWN, OWN_RESIDUAL, OWN_FLOOR)  # measured in the record itself
_T = TypeVar("_T")


@dataclass(frozen=True, kw_only=True)
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
        blank: it was measured where nothing swung, not between the harmonics of a signal.
    """

    sd: Array
    frequency_hz: Array
    psd: Array
    degrees: Array | None = None
    correlated_bins: float = 1.0
    source: str = "given"
    tones_hz: tuple[float, ...] = ()
    blank: bool = False
    _results: dict[Any, Any] = field(default_factory=dict, init=False, repr=False, compare=False)

    @classmethod
    def white(cls, sd: Array, sampling_rate_hz: float) -> NoiseModel:
        """Flat noise of known standard deviation (channels,)."""
        sd = np.asarray(sd, dtype=np.float64)
        grid = np.array([0.0, 0.5 * sampling_rate_hz])
        return cls(sd=sd, frequency_hz=grid, psd=np.repeat((2.0 * sd**2 / sampling_rate_hz)[:, None], 2, axis=1))

    @property
    def of_swings(self) -> bool:
        """Measured in ring-downs, where a flaw of the samples is a part of it; not in blank shots, nor given."""
        return not self.blank and self.source != "given"

    def flattened(self) -> NoiseModel:
        """Flat noise of the level far above the harmonics, and below the edge of the band, where a filter may begin.

        The model itself where that was not measured.
        """
        if self.degrees is None:
            return self
        share = self.frequency_hz / self.frequency_hz[-1]
        seen = (self.degrees > 0.0) & (share > LIMITS.flat_from_share) & (share < LIMITS.flat_to_share)
        if not seen.any():
            return self
        psd = np.repeat(_levels(self.psd[:, seen], self.degrees[seen])[:, None], share.size, axis=1)
        return replace(self, sd=sd_of(self.frequency_hz, psd), psd=psd)

    def kept(self, work: Callable[..., _T], *args: float) -> _T:
        """work(self, *args), never None, done once for all shots of a series that share this noise."""
        key = (work, *args)
        found = self._results.get(key)
        if found is None:
            if len(self._results) >= LIMITS.most_kept_results:
                self._results.clear()
            found = self._results[key] = work(self, *args)
        return cast(_T, found)

    def at_level(self, ratio: float, source: str) -> NoiseModel:
        """The model with so many times its standard deviation, known from elsewhere."""
        return replace(self, sd=self.sd * ratio, psd=self.psd * ratio**2, source=source)

    def without_tones(self, tones_hz: Array) -> NoiseModel:
        """The model with the lines of steady tones (tones,) replaced by the level beside them."""
        grid = self.frequency_hz
        if self.degrees is None or tones_hz.size == 0:
            return self
        return self._bridged(np.any(np.abs(grid - tones_hz[:, None]) < LIMITS.line_half_bins * grid[1], axis=0))

    def without_ringing(self, low_hz: float, high_hz: float) -> NoiseModel:
        """The model of a blank shot without a rotor that still swings between these frequencies, and its harmonics.

        Their bins are replaced by the level beside them; a model without such a rotor is returned as it is.
        """
        if self.degrees is None:
            return self
        grid = self.frequency_hz
        rings = np.zeros(grid.size, dtype=bool)
        margin = LIMITS.line_half_bins * grid[1]
        for k in range(1, LIMITS.most_harmonics + 1):
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
        most = gammaincinv(shape, 1.0 - LIMITS.ringing_chance / (self.psd.shape[0] * np.count_nonzero(seen))) / shape
        return bool(np.any(self.psd[:, seen] > most * beside[:, seen]))

    def _bridged(self, gap: np.ndarray) -> NoiseModel:
        """The model with these bins replaced by the level beside them."""
        assert self.degrees is not None
        degrees = np.where(gap, 0.0, self.degrees)
        # What was interpolated before may rest on a line: all gaps are bridged again.
        psd = bridge(self.psd, degrees == 0.0, degrees)
        return replace(self, sd=sd_of(self.frequency_hz, psd), psd=psd, degrees=degrees)


def estimate_noise(record: RingDownRecord, *, blank: bool = False) -> NoiseModel:
    """Noise of a record, from all its valid samples; blank: it is known to hold no signal.

    The averaged spectrum is read where the signal is not: harmonics are masked over the range their frequency
    sweeps through, as far up as they exceed the noise, and the gaps are bridged. The variance is the integral. An
    angle's is taken from differences of its samples (angle.py) wherever these are dense enough.
    """
    samples, rate = record.valid, record.sampling_rate_hz
    line = None if blank else find_oscillation(record)
    if record.quantity == "angle" and line is not None and line.significance >= LIMITS.line_significance:
        sd = angle_noise_sd(record, line.frequency_hz)
        if sd is not None:
            return replace(NoiseModel.white(np.full(record.channels, sd), rate), source=OWN)
    if line is None or line.significance < LIMITS.line_significance:
        spectra = segment_spectra(
            samples, rate, max(LIMITS.silent_segment_samples, samples.shape[1] // LIMITS.silent_segment_divisor)
        )
        mask = np.zeros(spectra.frequency_hz.size, dtype=bool)
    else:
        segment = max(
            int(LIMITS.segment_periods * rate / line.frequency_hz), min(LIMITS.segment_samples, samples.shape[1] // 2)
        )
        spectra = segment_spectra(samples, rate, segment)
        mask = _harmonic_mask(spectra, line.frequency_hz)
    # The lowest bins lack what the removal of the offset took from them.
    mask[: LIMITS.offset_bins] = True
    each, density = np.full(mask.size, spectra.degrees), spectra.density.mean(axis=0)
    mask |= np.count_nonzero(~mask) < LIMITS.fewest_bins
    psd = _flat(density, spectra.degrees) if mask.all() else bridge(density, mask, each)
    grid, degrees = spectra.frequency_hz, np.where(mask, 0.0, each)
    return NoiseModel(
        sd=sd_of(grid, psd),
        frequency_hz=grid,
        psd=psd,
        degrees=degrees,
        correlated_bins=spectra.correlated_bins,
        source=OWN,
        blank=blank,
    )


def _flat(density: Array, degrees: float) -> Array:
    """Flat noise (channels, k), where harmonics may be in every bin."""
    level = np.maximum(_quiet_level(density[:, LIMITS.offset_bins :], degrees), _TINY)
    return np.repeat(level[:, None], density.shape[1], axis=1)


def _quiet_level(density: Array, degrees: float) -> Array:
    """Level of the noise, (channels,), from the quietest of the bins (channels, k).

    Right where harmonics fill none of them; where they fill half, it is a sixth too large (as a standard deviation).
    """
    share = float(gammaincinv(degrees, LIMITS.quiet_share)) / degrees
    return np.asarray(np.quantile(density, LIMITS.quiet_share, axis=1) / share)


def sd_of(grid: Array, psd: Array) -> Array:
    """Standard deviations (channels,) of noise with this density."""
    return np.asarray(np.sqrt(np.sum(psd, axis=1) * (grid[1] - grid[0])))


def _harmonic_mask(spectra: SegmentSpectra, frequency_hz: float) -> np.ndarray:
    """True where the signal's harmonics may be, bool (k,)."""
    low, high = _sweep_range(spectra, frequency_hz)
    grid = spectra.frequency_hz
    mask = np.zeros(grid.size, dtype=bool)
    total = spectra.density.mean(axis=0)
    reference = _quiet_level(total[:, grid > 0.5 * grid[-1]], spectra.degrees)
    # The decay and the sweep inside a segment broaden the line beyond the window's own lobe.
    margin = LIMITS.line_broadening * spectra.lobe_hz
    quiet = 0
    for k in range(1, LIMITS.most_harmonics + 1):
        zone = _folded_zone(grid, k * low - margin, k * high + margin)
        if not zone.any():
            break
        mask |= zone
        level = np.max(total[:, zone], axis=1)
        quiet = quiet + 1 if np.all(level < LIMITS.harmonic_over_noise * reference) else 0
        if quiet == LIMITS.quiet_harmonics:
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
    window = (grid > LIMITS.sweep_low * frequency_hz) & (grid < LIMITS.sweep_high * frequency_hz)
    if not window.any():
        return frequency_hz, frequency_hz
    power = spectra.density.sum(axis=1)
    floor = np.median(power.mean(axis=0))
    peaks = np.max(power[:, window], axis=1)
    where = grid[window][np.argmax(power[:, window], axis=1)]
    seen = where[peaks > LIMITS.sweep_over_floor * floor]
    if seen.size == 0:
        return frequency_hz, frequency_hz
    low, high = min(frequency_hz, float(seen.min())), max(frequency_hz, float(seen.max()))
    return low * (1.0 - LIMITS.sweep_margin_share), high * (1.0 + LIMITS.sweep_margin_share)


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
    """Runs begin .. end-1 of bins that are not kept, and the neighbours on either side that replace them."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (~keep).astype(np.int8), [0]]))).tolist()
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        width = min(max(LIMITS.fewest_bridge_bins, end - begin), LIMITS.most_bridge_bins)
        sides = [slice(max(0, begin - width), begin), slice(end, end + width)]
        yield begin, end, [side for side in sides if keep[side].any()] or [slice(0, keep.size)]


def _levels(density: Array, degrees: Array) -> Array:
    """Mean density per channel from the medians of some bins, (channels,)."""
    # Ratio of median to mean of an average of k exponentially distributed powers.
    k = max(float(degrees[0]), 1.0)
    return np.asarray(np.maximum(np.median(density, axis=1) / (1.0 - 1.0 / (3.0 * k) + 0.0247 / k**2), _TINY))


def level_sd(noise: NoiseModel) -> float:
    """Relative standard deviation of a channel's noise power if the noise is white.

    0 for noise that is known, infinite if no bin was measured.
    """
    if noise.degrees is None:
        return 0.0
    keep = noise.degrees > 0.0
    if not keep.any():
        return math.inf
    weights = keep + math.sqrt(_MEDIAN_VARIANCE) * _lent(keep)
    variance = noise.correlated_bins * float(np.sum(weights[keep] ** 2 / noise.degrees[keep]))
    return math.sqrt(variance) / keep.size


def _lent(keep: np.ndarray) -> Array:
    """How many bins of gaps every bin replaces, as `bridge` fills them from both sides."""
    out = np.zeros(keep.size)
    for begin, end, seen in gaps(keep):
        for side in seen:
            out[side] += keep[side] * (end - begin) / (len(seen) * np.count_nonzero(keep[side]))
    return out
