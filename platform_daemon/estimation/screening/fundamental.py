"""Where the oscillation of a ring-down is in its spectrum."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.fft import next_fast_len, rfft

from platform_daemon.estimation.numerics.arrays import Array, centred, medians
from platform_daemon.estimation.thresholds import THRESHOLDS

from .frequency_search import block_means
from .spectral_lines import peak_shift

LIMITS = THRESHOLDS.screening

_BLACKMAN_HARRIS = (0.35875, -0.48829, 0.14128, -0.01168)
_HALF_LOBE_BINS = 4  # of the Blackman-Harris window


@dataclass(frozen=True)
class SpectralPeak:
    """The oscillation's fundamental: frequency in Hz and its power over the median power of the spectrum."""

    frequency_hz: float
    significance: float


def find_fundamental(
    samples: Array, sampling_rate_hz: float, weakest: float = LIMITS.fundamental_weakest_share
) -> SpectralPeak | None:
    """Fundamental frequency from the beginning of a record, (channels, n); None if there is nothing to see.

    The usual length settles most records; else ever longer beginnings are tried until the line is beyond doubt, or
    the length with the most significant line is used. Powers are added over the channels without weights, because then
    the fundamental exceeds 2f below 90 degrees for any orientation; where gains differ, a line at half the peak's
    frequency reveals a 2f peak. weakest: the least share of the power at 2f that the fundamental can have.
    """
    length = min(LIMITS.fundamental_usual_samples, samples.shape[1])
    line = _quick_look(samples[:, :length], sampling_rate_hz, weakest)
    if line is not None and _is_certain(line, length / sampling_rate_hz):
        return line
    best: SpectralPeak | None = None
    length = min(LIMITS.fundamental_first_samples, samples.shape[1])
    while True:
        line = _strongest_line(samples[:, :length], sampling_rate_hz, weakest)
        if line is not None and (best is None or line.significance > best.significance):
            best = line
        certain = line is not None and _is_certain(line, length / sampling_rate_hz)
        if certain or length == samples.shape[1]:
            break
        length = min(2 * length, samples.shape[1])
    best = line if certain else best
    seconds = samples.shape[1] / sampling_rate_hz
    if best is None or not certain or best.frequency_hz * seconds < LIMITS.fundamental_enough_periods:
        return _few_periods(samples, seconds) or best
    return best


def _few_periods(samples: Array, seconds: float) -> SpectralPeak | None:
    """The sinusoid that explains most of a record of a few periods, which a windowed spectrum cannot resolve."""
    block = max(1, samples.shape[1] // LIMITS.fundamental_short_points)
    means = samples[:, : samples.shape[1] // block * block].reshape(samples.shape[0], -1, block).mean(axis=2)
    means -= means.mean(axis=1, keepdims=True)
    total = float(np.sum(means**2))
    phase = 2.0 * np.pi * (np.arange(means.shape[1]) + 0.5) / means.shape[1]
    trials = np.arange(0.5, LIMITS.fundamental_enough_periods, LIMITS.fundamental_trial_periods)
    waves = [np.stack([np.ones(phase.size), np.cos(p * phase), np.sin(p * phase)]) for p in trials]
    explained = [float(np.sum((np.linalg.qr(w.T)[0].T @ means.T) ** 2)) for w in waves]
    best = int(np.argmax(explained))
    if not explained[best] > LIMITS.fundamental_explained_share * total:
        return None
    return SpectralPeak(float(trials[best]) / seconds, np.inf)


def _quick_look(samples: Array, sampling_rate_hz: float, weakest: float) -> SpectralPeak | None:
    """The strongest line of a beginning; of means of neighbouring samples, if they hold most of its power."""
    block = int(sampling_rate_hz / LIMITS.fundamental_quick_rate_hz)
    if block > 1:
        n = samples.shape[1] // block
        means = block_means(samples, 0, block, n)
        centre = means.sum(axis=1) / n
        means -= centre[:, None]
        used = samples[:, : n * block]
        power = sum(float(row @ row) for row in used)
        if np.vdot(means, means) > LIMITS.fundamental_kept_share * (power / block - n * (centre @ centre)):
            return _strongest_line(means, sampling_rate_hz / block, weakest)
    return _strongest_line(samples, sampling_rate_hz, weakest)


def _is_certain(line: SpectralPeak, seconds: float) -> bool:
    """Beyond doubt, and seen for long enough."""
    return (
        line.significance > LIMITS.fundamental_certain_power
        and line.frequency_hz * seconds > LIMITS.fundamental_enough_periods
    )


@lru_cache(8)
def _window(n: int) -> Array:
    """The Blackman-Harris window, (n,); importing scipy.signal for it would take longer than a hundred fits."""
    turn = 2.0 * np.pi * np.arange(n) / (n - 1)
    return np.asarray(sum(a * np.cos(k * turn) for k, a in enumerate(_BLACKMAN_HARRIS)))


def _strongest_line(samples: Array, sampling_rate_hz: float, weakest: float) -> SpectralPeak | None:
    """Strongest spectral line of a segment, halved if it is the second harmonic: with `weakest` of its power there."""
    n = samples.shape[1]
    # Few periods are few bins: pad, so that the peak is found between them.
    size = next_fast_len(n if n >= LIMITS.fundamental_many_points else 2 * n, real=True)
    padded = centred(samples, size)
    padded[:, :n] *= _window(n)
    spectrum = rfft(padded, axis=1)
    power = (spectrum.real**2 + spectrum.imag**2).sum(axis=0)
    lobe = int(np.ceil(_HALF_LOBE_BINS * size / n))
    power[: 2 * lobe] = 0.0
    floor = float(medians(power[2 * lobe :]))
    peak = int(np.argmax(power))
    if power[peak] <= 0.0:
        return None
    half = peak / 2.0
    if half > 2 * lobe:
        near = slice(int(half) - lobe, int(half) + lobe + 1)
        candidate = near.start + int(np.argmax(power[near]))
        least = max(weakest, LIMITS.fundamental_folded_share if _may_be_folded(candidate, peak, size, lobe) else 0.0)
        stands_out = power[candidate] > max(LIMITS.fundamental_over_floor * floor, least * power[peak])
        is_local = near.start < candidate < near.stop - 1
        if stands_out and is_local:
            peak = candidate
    shift = peak_shift(power, peak)
    significance = float(power[peak]) / floor if floor > 0.0 else np.inf
    return SpectralPeak((peak + shift) * sampling_rate_hz / size, significance)


def _may_be_folded(at: int, peak: int, size: int, lobe: int) -> bool:
    """True if a weak harmonic of the line at bin `peak` appears near bin `at` of a transform of so many samples."""
    places = [k * peak % size for k in range(3, LIMITS.fundamental_harmonics + 1)]
    return any(abs(min(place, size - place) - at) <= lobe for place in places if place)
