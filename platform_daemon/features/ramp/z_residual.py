"""What a shot shows out of the plane of the main mode: the z component of dm/dt less what leaks into it from x and y.

The paper reads side modes off the z channel ("Measurement Sequence"). Here the residual is freed from noise first: it
is cut into short blocks, of their spectra only what stands out of the noise is kept with its surroundings, and the
largest value in time of what that makes is what counts (denoising by a hard threshold: Donoho and Johnstone, Biometrika
81 (1994) 425). Blocks, because the duration of side modes varies: those of a thread continue through the whole window,
those of a jewel that slips are over within some 20 ms. The noise is that of shots without excitation; lines that those
have already, as hum, are taken out of every shot.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, rfft
from scipy.ndimage import maximum_filter
from scipy.signal import ShortTimeFFT, windows

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.screening.spectral_lines import median_level

VISIBLE_AM2_PER_S = 0.4
"""Largest |z residual| from which side modes count as visible, A m^2/s: seven times the noise of the paper's z."""
_BAND_HZ = 20.0, 3000.0
_BLOCK_S = 0.02
_PER_BLOCK = 4  # blocks begin so often within one
_FALSE = 1e-4  # chance that noise alone puts anything into a shot
_LINE_HZ = 20.0  # on either side of a line belongs to it
_FLOOR_SHARE = 0.02  # of the largest line: weaker ones are not reported
_MOST_LINES = 8
_HUM = 60.0  # times the level around it: a line of shots at low amplitude
_MOST_HUM = 6
_BANDS = 40  # in which that level is found


@dataclass(frozen=True)
class SideLine:
    """A line in the z residual: frequency Hz, and the largest size of what stands around it, A m^2/s."""

    frequency_hz: float
    size_am2_per_s: float


@dataclass(frozen=True)
class ZNoise:
    """Mean power of the z residual where nothing moves, or nothing but the main mode, per frequency and block, (k, m);
    of n samples at rate_hz; lines that were there, (h,) Hz."""

    power: Array
    samples: int
    rate_hz: float
    hum_hz: Array

    @classmethod
    def of(cls, shots: Sequence[Array], rate_hz: float) -> ZNoise:
        """From dm/dt (3, n) of blank shots, or of shots at low amplitude, all of one length.

        Raises:
            ValueError: no shots.
        """
        if not shots:
            raise ValueError("the noise of the z residual needs a blank shot")
        hum_hz = _hum([_beside_plane(s, rate_hz, np.empty(0)) for s in shots], rate_hz)
        blocks = _blocks(rate_hz)
        power = np.mean([np.abs(blocks.stft(_beside_plane(s, rate_hz, hum_hz))) ** 2 for s in shots], axis=0)
        mean = power.mean(axis=1, keepdims=True)
        found = np.maximum(np.broadcast_to(mean, power.shape), 1e-12 * float(mean.max()) + np.finfo(float).tiny).copy()
        # Blocks that reach beyond the record see what is left of a line cut off.
        ends = [*range(_PER_BLOCK), *range(-_PER_BLOCK, 0)]
        found[:, ends] = np.maximum(found[:, ends], power[:, ends])
        return cls(found, shots[0].shape[1], rate_hz, hum_hz)


@dataclass(frozen=True)
class ZResidual:
    """What a shot shows out of the plane.

    Attributes:
        size_am2_per_s: largest size in time of what stands out of the noise; 0: nothing does.
        sd_am2_per_s: standard deviation of this by noise.
        lines: what it is made of, the largest first.
    """

    size_am2_per_s: float
    sd_am2_per_s: float
    lines: tuple[SideLine, ...]


def z_residual(dmdt: Array, noise: ZNoise) -> ZResidual:
    """Of dm/dt (3, n), A m^2/s in world axes.

    Raises:
        ValueError: not as many samples as the noise was measured in.
    """
    n = dmdt.shape[1]
    if n != noise.samples:
        raise ValueError(f"{n} samples, and {noise.samples} in the shots that the noise was measured in")
    blocks = _blocks(noise.rate_hz)
    found = blocks.stft(_beside_plane(dmdt, noise.rate_hz, noise.hum_hz))
    ratios = np.abs(found) ** 2 / noise.power
    # Noise that has grown since then is noise all the same; side modes fill little of the spectrum.
    louder = max(1.0, float(np.median(ratios)) / math.log(2.0))
    inside = (blocks.f >= _BAND_HZ[0]) & (blocks.f <= _BAND_HZ[1])
    ratios = np.where(inside[:, None], ratios / louder, 0.0)
    out = ratios > math.log(int(inside.sum()) * ratios.shape[1] / _FALSE)
    if not out.any():
        unseen = np.abs(blocks.f - np.mean(_BAND_HZ)) < 1.5 * blocks.delta_f
        return ZResidual(0.0, _sd(noise, blocks, louder, unseen, found.shape[1] // 2), ())
    # Beside what stands out there is more of it, as long as it is not less than noise.
    kept = maximum_filter(out, size=3) & (ratios > 1.0)
    clean = np.real(blocks.istft(np.where(kept, found, 0.0), k1=n))
    size = np.abs(clean)
    at = min(round(int(np.argmax(size)) / blocks.hop) - blocks.p_min, kept.shape[1] - 1)
    return ZResidual(float(size.max()), _sd(noise, blocks, louder, kept[:, at], at), _lines(clean, noise.rate_hz))


def _blocks(rate_hz: float) -> ShortTimeFFT:
    hop = max(2, round(_BLOCK_S * rate_hz / _PER_BLOCK))
    return ShortTimeFFT(windows.hann(_PER_BLOCK * hop, sym=False), hop, rate_hz)


def _sd(noise: ZNoise, blocks: ShortTimeFFT, louder: float, kept: np.ndarray, at: int) -> float:
    """Standard deviation in time of the noise at the frequencies kept, in block `at`: white noise of variance 1 has the
    power sum(w^2) at each of them."""
    share = float(np.sum(noise.power[kept, at])) / float(np.sum(blocks.win**2)) / blocks.f_pts
    return math.sqrt(louder * share)


def _beside_plane(dmdt: Array, rate_hz: float, hum_hz: Array) -> Array:
    """z less what leaks into it from x and y, and less these lines, by least squares, (n,)."""
    time = np.linspace(-1.0, 1.0, dmdt.shape[1])
    phase = np.outer(hum_hz, 2.0 * math.pi / rate_hz * np.arange(dmdt.shape[1]))
    waves = np.concatenate([np.cos(phase), np.sin(phase)])
    # A line a little off its frequency turns through the record: to first order it grows along it.
    known = np.concatenate([dmdt[:2], waves, time * waves])
    share = np.linalg.lstsq(known @ known.T, known @ dmdt[2], rcond=None)[0]
    return np.asarray(dmdt[2] - share @ known)


def _hum(residuals: Sequence[Array], rate_hz: float) -> Array:
    """Frequencies of the lines that all residuals have, the strongest first, (h,) Hz."""
    n = residuals[0].size
    power = np.mean([np.abs(rfft(r)) ** 2 for r in residuals], axis=0)
    edges = np.unique(np.geomspace(8, power.size, _BANDS).astype(int))
    ratios = power / (np.asarray(median_level(power[None], [0, *edges])[0]) + np.finfo(float).tiny)
    bins = np.arange(power.size)
    inside = (bins * rate_hz / n >= _BAND_HZ[0]) & (bins * rate_hz / n <= _BAND_HZ[1])
    ratios = np.where(inside, ratios, 0.0)
    found: list[float] = []
    while len(found) < _MOST_HUM and (peak := int(np.argmax(ratios))) and ratios[peak] > _HUM:
        near = slice(peak - 1, peak + 2)
        found.append(float(np.sum(bins[near] * power[near]) / np.sum(power[near])) * rate_hz / n)
        ratios[max(0, peak - 5) : peak + 6] = 0.0
    return np.array(found)


def _lines(clean: Array, rate_hz: float) -> tuple[SideLine, ...]:
    """The strongest frequency with its surroundings, then the strongest of what is left, and so on."""
    n = clean.size
    spectrum = rfft(clean)
    width = max(1, round(_LINE_HZ * n / rate_hz))
    found: list[SideLine] = []
    while len(found) < _MOST_LINES:
        peak = int(np.argmax(np.abs(spectrum)))
        near = slice(max(0, peak - width), peak + width + 1)
        part = np.zeros_like(spectrum)
        part[near], spectrum[near] = spectrum[near], 0.0
        size = float(np.max(np.abs(irfft(part, n))))
        if found and size < _FLOOR_SHARE * found[0].size_am2_per_s:
            break
        found.append(SideLine(peak * rate_hz / n, size))
    return tuple(sorted(found, key=lambda line: -line.size_am2_per_s))
