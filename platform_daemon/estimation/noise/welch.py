"""Averaged power densities of overlapping segments, with the number of independent values behind every average."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.fft import irfft, rfft

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.noise


@dataclass(frozen=True, kw_only=True)
class SegmentSpectra:
    """One-sided power densities of overlapping segments.

    Attributes:
        frequency_hz: (k,).
        density: (segments, channels, k), unit^2/Hz.
        lobe_hz: half width of the window's main lobe; beyond it leakage is below 1e-12 of a line's power.
        degrees: independent complex values behind the average of one bin over the segments.
        correlated_bins: neighbouring bins that share one independent value.
    """

    frequency_hz: Array
    density: Array
    lobe_hz: float
    degrees: float
    correlated_bins: float


def segment_spectra(samples: Array, sampling_rate_hz: float, segment: int) -> SegmentSpectra:
    """Kaiser-windowed periodograms of segments of about so many samples, spread evenly; weighted means removed."""
    n = samples.shape[1]
    segment = min(_quick_length(segment), n - n % 2)
    window, correlated_bins = _window(segment)
    hop = max(segment // LIMITS.welch_hop_divisor, -(-(n - segment) // (LIMITS.welch_segments - 1)), 1)
    starts = range(0, n - segment + 1, hop)
    scale = 2.0 / (sampling_rate_hz * float(window @ window))
    density = np.stack([_periodogram(samples[:, s : s + segment], window, scale) for s in starts])
    frequency = np.arange(segment // 2 + 1) * sampling_rate_hz / segment
    lobe_bins = np.sqrt(1.0 + (LIMITS.welch_kaiser_beta / np.pi) ** 2)
    degrees = _independent(segment, hop, len(starts))
    return SegmentSpectra(
        frequency_hz=frequency,
        density=density,
        lobe_hz=float(lobe_bins * sampling_rate_hz / segment),
        degrees=degrees,
        correlated_bins=correlated_bins,
    )


def _quick_length(segment: int) -> int:
    """The next even length below that transforms fast; few lengths, so that their windows are found in the cache."""
    octave = max(segment, LIMITS.welch_shortest_samples).bit_length() - 4
    return (segment >> octave << octave) if segment >= LIMITS.welch_shortest_samples else LIMITS.welch_shortest_samples


@lru_cache(32)
def _window(segment: int) -> tuple[Array, float]:
    """Window (segment,), and sum over lags of the squared correlation of its bins."""
    window = np.kaiser(segment, LIMITS.welch_kaiser_beta)
    squares = window**2
    return window, float(segment * (squares @ squares) / np.sum(squares) ** 2)


@lru_cache(64)
def _independent(segment: int, hop: int, count: int) -> float:
    """How many independent periodograms `count` overlapping ones are worth."""
    window, _ = _window(segment)
    autocorrelation = irfft(np.abs(rfft(window, 2 * segment)) ** 2)[:segment]
    shared = (autocorrelation[::hop] / autocorrelation[0]) ** 2
    lags = np.arange(1, min(shared.size, count))
    return float(count / (1.0 + 2.0 * np.sum(shared[lags] * (1.0 - lags / count))))


def _periodogram(piece: Array, window: Array, scale: float) -> Array:
    """Power density of a windowed piece (channels, n). Its weighted mean is an offset; its plain mean holds signal."""
    offset = (piece @ window) / float(window.sum())
    spectrum = rfft((piece - offset[:, None]) * window, axis=1)
    return np.asarray(scale * (spectrum.real**2 + spectrum.imag**2))
