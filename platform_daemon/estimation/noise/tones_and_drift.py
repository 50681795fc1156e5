"""What stands in a residual and is no ring-down: steady tones such as mains hum, and slow drift.

A tone is a line that is narrow, beyond doubt, outside the range that the signal's harmonics sweep through, and as
strong at the end as at the beginning: what decays is another oscillation, and not for this module to remove.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre
from scipy.fft import next_fast_len

from ..numerics.arrays import Array, ComplexArray, medians
from ..screening.frequency_search import block_means
from ..screening.spectral_lines import Zones, is_mains, median_level, peak_shift, periodogram

_BETA = 8.0
_LOBE_BINS = 2.8  # half width of the window's main lobe
_PADDING = 4
_NEIGHBOURHOOD = 40.0  # bins on either side, from which the level beside a line is read
_SURE = 25.0  # power over the level beside: exceeded by noise once in 1e7 records
_WORTH_A_SEARCH = 18.0  # over the median; a line of _SURE is above it wherever it falls between the bins
_MOST_TONES = 16
_MANY_PEAKS = 24
_STRETCHES = 8
_CHANGE_SIGMA = 4.0
_CHANGE, _MAINS_CHANGE = 0.01, 0.15  # of a steady tone's size over the window; mains is less steady
_MAINS_FALL = 0.04  # of its size over the window that a voltage of mains may do; larger changes of a load are steps
_ALIKE, _ALIKE_SIGMA = 0.1, 3.0  # departures from an exponential decay: of the fall, or by chance
_CHIRP, _MAINS_CHIRP = 0.4, 2.0  # rad per window squared: a quarter of it is the phase at either end
_MAINS_TOLERANCE = 0.005
_MISSED = 0.1  # bins, by which noise and drift may shift a slow line
_HIGHEST_DEGREE = 8
_DRIFT_POINTS = 256
_SURE_DRIFT = 6.0  # standard deviations


def may_hold_tones(residual: Array, spectrum: Array) -> bool:
    """A cheap look: is a search for tones worth its time?

    residual: (channels, n); spectrum: (channels, bins) its plain power, in units of any level, from bin 1 on.
    """
    # Where more than half of the bins are above this level, so is their median, which takes long to find.
    level = spectrum.max(axis=1) / _WORTH_A_SEARCH
    if (2 * np.count_nonzero(spectrum < level[:, None], axis=1) < spectrum.shape[1] - 1).all():
        return False
    standing = spectrum / np.maximum(medians(spectrum), 1e-300)[:, None]
    channels, bins = np.nonzero(standing > _WORTH_A_SEARCH)
    if bins.size > _MANY_PEAKS:
        return True
    # A tone between two bins is stronger than either; noise hardly is.
    return any(
        standing[c, k] * _gain_between_bins(residual[c], int(k) + 1) > _SURE / np.log(2.0)
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
    return np.asarray(np.kaiser(n, _BETA))


def find_tones(residual: Array, rate_hz: float, zones: Zones | None) -> Array:
    """Frequencies in Hz of steady tones in a residual (channels, n), strongest first, (tones,).

    zones: None: there is no signal.
    """
    n = residual.shape[1]
    size = next_fast_len(_PADDING * n, real=True)
    power = periodogram(residual - residual.mean(axis=1, keepdims=True), _window(n), size)
    bin_hz = rate_hz / size
    # Each channel by its own level: a tone counts where it stands out, wherever that is.
    level = _level_beside(power, size / n)
    standing = np.max(power / level, axis=0)
    lobe = int(np.ceil(_LOBE_BINS * size / n))
    tones: list[float] = []
    for k in np.argsort(standing)[::-1]:
        if standing[k] < _SURE or len(tones) == _MOST_TONES:
            break
        near = slice(max(0, k - lobe), k + lobe + 1)
        if not lobe <= k < standing.size - 1 or standing[k] < standing[near].max():
            continue
        frequency = (k + peak_shift(standing, int(k))) * bin_hz
        # What is slower than two lobes may be drift, unless it is where hum is expected.
        drift = k < 2 * lobe and not is_mains(frequency, relative=_MAINS_TOLERANCE, missed_hz=_MISSED * rate_hz / n)
        known = any(abs(frequency - t) < lobe * bin_hz for t in tones)
        if drift or known or (zones is not None and zones.holds(frequency)):
            continue
        if _keeps_size(residual, frequency, rate_hz) and _keeps_pitch(residual, frequency, rate_hz, level[:, k]):
            tones.append(frequency)
    return np.array(tones)


def _level_beside(power: Array, padding: float) -> Array:
    """Mean level around each bin, (channels, bins)."""
    block = max(8, int(_NEIGHBOURHOOD * padding))
    edges = block * np.arange(max(1, power.shape[1] // block) + 1)
    return median_level(power, edges) / np.log(2.0)


def _keeps_size(residual: Array, frequency_hz: float, rate_hz: float) -> bool:
    """No trend in the size of a tone over the window, beyond chance and beyond what mains hum does."""
    n = residual.shape[1] // _STRETCHES
    used = n * _STRETCHES
    wave = np.exp(-2j * np.pi * frequency_hz / rate_hz * np.arange(used))
    # A window in each stretch, so that strong neighbours do not leak in.
    taper = np.hanning(n + 2)[1:-1]
    pieces = (residual[:, :used] * wave).reshape(-1, _STRETCHES, n) @ (taper / taper.sum())
    sizes = np.linalg.norm(pieces, axis=0)
    noise = float(np.sqrt(np.mean(np.abs(np.diff(pieces, 2, axis=1)) ** 2) / 6.0))
    place = np.linspace(-0.5, 0.5, _STRETCHES)
    slope = float(place @ sizes / (place @ place))
    sd = noise / float(np.sqrt(place @ place))
    mains = is_mains(frequency_hz, relative=_MAINS_TOLERANCE)
    # In less than two periods a stretch shows its own phase too.
    if mains and n * frequency_hz / rate_hz > 2.0 and _decays(sizes, noise):
        return False
    allowed = (_MAINS_CHANGE if mains else _CHANGE) * float(sizes.mean())
    return abs(slope) < max(_CHANGE_SIGMA * sd, allowed)


def _decays(sizes: Array, noise: float) -> bool:
    """Sizes in equal stretches (n,) fall as those of a resonator: exponentially all the time, and by enough.

    Mains wanders: its size may change as much, but hardly at the same rate throughout.
    """
    place = np.linspace(-0.5, 0.5, sizes.size)
    logarithms = np.log(np.maximum(sizes, 1e-300))
    fall = -float(place @ logarithms / (place @ place))
    departures = np.abs(logarithms - logarithms.mean() + fall * place)
    relative = noise / float(sizes.mean())
    sure = fall > max(_MAINS_FALL, _CHANGE_SIGMA * relative / float(np.sqrt(place @ place)))
    return bool(sure and departures.max() < max(_ALIKE * fall, _ALIKE_SIGMA * relative))


def _keeps_pitch(residual: Array, frequency_hz: float, rate_hz: float, level: Array) -> bool:
    """No chirp and no decay in the middle of the window, beyond chance; level (channels,): noise power of a sample.

    With time t in windows and the window w, a tone exp((d + i k t) t) has the moments sum(w t) ~ d and
    sum(w (t^2 - mean)) ~ i k.
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
    allowed = (_MAINS_CHANGE, _MAINS_CHIRP) if is_mains(frequency_hz, relative=_MAINS_TOLERANCE) else (_CHANGE, _CHIRP)
    return bool(np.all(found < np.maximum(_CHANGE_SIGMA * noise, allowed)))


@lru_cache(32)
def _drifts(n: int) -> Array:
    """Legendre polynomials at n points, each of unit norm, (n, degrees)."""
    columns = legendre.legvander(np.linspace(-1.0, 1.0, n), _HIGHEST_DEGREE)
    return np.asarray(columns / np.linalg.norm(columns, axis=0))


def drift_degree(residual: Array) -> int:
    """Highest degree of a polynomial in time that stands out of a residual (channels, n) over its noise, or 0."""
    block = max(1, residual.shape[1] // _DRIFT_POINTS)
    n = residual.shape[1] // block
    if n < 4 * _HIGHEST_DEGREE:
        return 0
    means = block_means(residual, 0, block, n)
    sure = block**0.5 * np.abs(means @ _drifts(n)).max(axis=0)[1:] > _SURE_DRIFT
    return int(np.flatnonzero(sure)[-1]) + 1 if sure.any() else 0
