"""What a residual holds that is neither noise nor ring-down: steady tones such as mains hum, and slow drift.

A tone is a line that is narrow, beyond doubt, outside the range that the signal's harmonics sweep through, and as
strong at the end as at the beginning: what decays is another oscillation, which this module does not remove.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre
from scipy.fft import next_fast_len

from platform_daemon.estimation.numerics.arrays import Array, ComplexArray, medians
from platform_daemon.estimation.screening.frequency_search import block_means
from platform_daemon.estimation.screening.spectral_lines import Zones, is_mains, median_level, peak_shift, periodogram
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.noise


def may_hold_tones(residual: Array, spectrum: Array) -> bool:
    """A cheap look: is a search for tones worth its time?

    residual: (channels, n); spectrum: (channels, bins) its plain power, in units of any level, from bin 1 on.
    """
    # Where more than half of the bins are above this level, so is their median, which takes long to find.
    level = spectrum.max(axis=1) / LIMITS.tone_search_power
    if (2 * np.count_nonzero(spectrum < level[:, None], axis=1) < spectrum.shape[1] - 1).all():
        return False
    standing = spectrum / np.maximum(medians(spectrum), 1e-300)[:, None]
    channels, bins = np.nonzero(standing > LIMITS.tone_search_power)
    if bins.size > LIMITS.many_peaks:
        return True
    # A tone between two bins is stronger than either; noise hardly is.
    return any(
        standing[c, k] * _gain_between_bins(residual[c], int(k) + 1) > LIMITS.tone_power / np.log(2.0)
        for c, k in zip(channels, bins, strict=True)
    )


def _gain_between_bins(signal: Array, k: int) -> float:
    """Largest power within half a bin of bin k, over the power at it."""
    turns, shifts = _bin_waves(signal.size)
    power = np.abs(shifts @ (turns[k * np.arange(signal.size) % signal.size] * signal)) ** 2
    return float(power.max() / max(power[4], 1e-300))


@lru_cache(4)
def _bin_waves(n: int) -> tuple[ComplexArray, ComplexArray]:
    """exp(-2 pi i t / n) over t, (n,), and its powers from -1/2 to 1/2, (9, n)."""
    phase = -2j * np.pi / n * np.arange(n)
    return np.exp(phase), np.exp(np.linspace(-0.5, 0.5, 9)[:, None] * phase)


@lru_cache(4)
def _window(n: int) -> Array:
    """Kaiser window, drawn once."""
    return np.asarray(np.kaiser(n, LIMITS.tone_kaiser_beta))


def find_tones(residual: Array, rate_hz: float, zones: Zones | None) -> Array:
    """Frequencies in Hz of steady tones in a residual (channels, n), strongest first, (tones,).

    zones: None: there is no signal.
    """
    n = residual.shape[1]
    size = next_fast_len(LIMITS.tone_padding * n, real=True)
    power = periodogram(residual - residual.mean(axis=1, keepdims=True), _window(n), size)
    bin_hz = rate_hz / size
    # Each channel by its own level: a tone counts if it exceeds the level in any channel.
    level = _level_beside(power, size / n)
    standing = np.max(power / level, axis=0)
    lobe = int(np.ceil(LIMITS.tone_lobe_bins * size / n))
    tones: list[float] = []
    for k in np.argsort(standing)[::-1]:
        if standing[k] < LIMITS.tone_power or len(tones) == LIMITS.most_tones:
            break
        near = slice(max(0, k - lobe), k + lobe + 1)
        if not lobe <= k < standing.size - 1 or standing[k] < standing[near].max():
            continue
        frequency = (k + peak_shift(standing, int(k))) * bin_hz
        # What is slower than two lobes may be drift, unless it is where hum is expected.
        drift = k < 2 * lobe and not is_mains(
            frequency, relative=LIMITS.mains_share, missed_hz=LIMITS.tone_missed_bins * rate_hz / n
        )
        known = any(abs(frequency - t) < lobe * bin_hz for t in tones)
        if drift or known or (zones is not None and zones.holds(frequency)):
            continue
        if _keeps_size(residual, frequency, rate_hz) and _keeps_pitch(residual, frequency, rate_hz, level[:, k]):
            tones.append(frequency)
    return np.array(tones)


def _level_beside(power: Array, padding: float) -> Array:
    """Mean level around each bin, (channels, bins)."""
    block = max(LIMITS.tone_fewest_bins, int(LIMITS.tone_neighbourhood_bins * padding))
    edges = block * np.arange(max(1, power.shape[1] // block) + 1)
    return median_level(power, edges) / np.log(2.0)


def _keeps_size(residual: Array, frequency_hz: float, rate_hz: float) -> bool:
    """No trend in the size of a tone over the window, beyond chance and beyond what mains hum does."""
    n = residual.shape[1] // LIMITS.tone_stretches
    used = n * LIMITS.tone_stretches
    wave = np.exp(-2j * np.pi * frequency_hz / rate_hz * np.arange(used))
    # A window in each stretch, so that strong neighbours do not leak in.
    taper = np.hanning(n + 2)[1:-1]
    pieces = (residual[:, :used] * wave).reshape(-1, LIMITS.tone_stretches, n) @ (taper / taper.sum())
    sizes = np.linalg.norm(pieces, axis=0)
    noise = float(np.sqrt(np.mean(np.abs(np.diff(pieces, 2, axis=1)) ** 2) / 6.0))
    place = np.linspace(-0.5, 0.5, LIMITS.tone_stretches)
    slope = float(place @ sizes / (place @ place))
    sd = noise / float(np.sqrt(place @ place))
    mains = is_mains(frequency_hz, relative=LIMITS.mains_share)
    # In less than two periods a stretch shows its own phase too.
    if mains and n * frequency_hz / rate_hz > 2.0 and _decays(sizes, noise):
        return False
    allowed = (LIMITS.mains_change_share if mains else LIMITS.tone_change_share) * float(sizes.mean())
    return abs(slope) < max(LIMITS.tone_change_sigma * sd, allowed)


def _decays(sizes: Array, noise: float) -> bool:
    """Sizes in equal stretches (n,) fall as those of a resonator: exponentially all the time, and by enough.

    Mains wanders: its size may change as much, but hardly at the same rate throughout.
    """
    place = np.linspace(-0.5, 0.5, sizes.size)
    logarithms = np.log(np.maximum(sizes, 1e-300))
    fall = -float(place @ logarithms / (place @ place))
    departures = np.abs(logarithms - logarithms.mean() + fall * place)
    relative = noise / float(sizes.mean())
    sure = fall > max(LIMITS.mains_fall, LIMITS.tone_change_sigma * relative / float(np.sqrt(place @ place)))
    return bool(
        sure and departures.max() < max(LIMITS.decay_departure_share * fall, LIMITS.decay_departure_sigma * relative)
    )


def _keeps_pitch(residual: Array, frequency_hz: float, rate_hz: float, level: Array) -> bool:
    """No chirp and no decay in the middle of the window, beyond chance; level (channels,): noise power of a sample.

    With time t in windows and the window w, a tone exp((d + i k t) t) has the moments sum(w t) ~ d and
    sum(w (t^2 - mean)) ~ i k: d is the relative change of its amplitude over the window, k its chirp in rad.  The
    channels are combined coherently, with the weights of a matched filter (`weights`); `snr` is the power of the tone
    over that of the noise.
    """
    n = residual.shape[1]
    window, time = _window(n), np.linspace(-0.5, 0.5, n)
    mean = float(window @ time**2 / window.sum())
    shapes = np.stack([window, window * time, window * (time**2 - mean)])
    spread = shapes @ np.stack([time**0, time, time**2]).T / window.sum()
    wave = np.exp(-2j * np.pi * frequency_hz / rate_hz * np.arange(n))
    moments = (residual * wave) @ shapes.T
    weights = np.conj(moments[:, 0]) / level
    whole = float((weights @ moments[:, 0]).real)
    ratios, snr = weights @ moments[:, 1:] / whole, whole / float(window @ window)
    found = np.abs([ratios[0].real / spread[1, 1], ratios[1].imag / spread[2, 2]])
    noise = np.sqrt(0.5 * np.sum(shapes[1:] ** 2, axis=1) / np.sum(window**2) / snr) / np.diag(spread)[1:]
    allowed = (
        (LIMITS.mains_change_share, LIMITS.mains_chirp_rad)
        if is_mains(frequency_hz, relative=LIMITS.mains_share)
        else (LIMITS.tone_change_share, LIMITS.tone_chirp_rad)
    )
    return bool(np.all(found < np.maximum(LIMITS.tone_change_sigma * noise, allowed)))


@lru_cache(32)
def _drifts(n: int) -> Array:
    """Legendre polynomials at n points, each of unit norm, (n, degrees)."""
    columns = legendre.legvander(np.linspace(-1.0, 1.0, n), LIMITS.drift_degree)
    return np.asarray(columns / np.linalg.norm(columns, axis=0))


def drift_degree(residual: Array) -> int:
    """Highest degree of a polynomial in time that exceeds the noise of a residual (channels, n), or 0."""
    block = max(1, residual.shape[1] // LIMITS.drift_points)
    n = residual.shape[1] // block
    if n < LIMITS.drift_points_per_degree * LIMITS.drift_degree:
        return 0
    means = block_means(residual, 0, block, n)
    sure = block**0.5 * np.abs(means @ _drifts(n)).max(axis=0)[1:] > LIMITS.drift_sigma
    return int(np.flatnonzero(sure)[-1]) + 1 if sure.any() else 0
