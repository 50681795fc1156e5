"""What a shot shows out of the plane of the main mode: the z component of dm/dt less what leaks into it from x and y.

The paper reads side modes off the z channel ("Measurement Sequence"). Here the residual is freed from noise first: of
its spectrum only what stands out of the noise is kept, lines with their surroundings, and its largest value in time is
what counts. The noise is that of shots at low amplitude, hum included: what is there without side modes is none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft
from scipy.ndimage import maximum_filter1d

from platform_daemon.estimation import Array, median_level

VISIBLE_AM2_PER_S = 0.4
"""Largest |z residual| from which side modes count as visible, A m^2/s: seven times the paper's noise in z."""
_BAND_HZ = 20.0, 3000.0
_BANDS = 40  # in which the level of the noise is found
_FALSE = 1e-4  # chance that noise alone puts a line into a shot
_BESIDE_HZ = 4.0  # on either side of what stands out belongs to it
_SMEARED_HZ = 2.0  # by which hum may move
_MOST_LINES = 8


@dataclass(frozen=True)
class SideLine:
    """A line in the z residual: frequency Hz, and the largest size of what stands around it, A m^2/s."""

    frequency_hz: float
    size_am2_per_s: float


@dataclass(frozen=True)
class ZNoise:
    """The power of the z residual per bin where nothing moves but the main mode, (bins,); of n samples at rate_hz."""

    power: Array
    samples: int
    rate_hz: float

    @classmethod
    def of(cls, shots: Sequence[Array], rate_hz: float) -> ZNoise:
        """From dm/dt (3, n) of shots at low amplitude, all of one length.

        In every bin the larger of the level around it and of what the shots have on average within 2 Hz, so that hum
        is noise.

        Raises:
            ValueError: no shots.
        """
        if not shots:
            raise ValueError("the noise of the z residual needs a shot at low amplitude")
        spectra = np.stack([_power(_beside_plane(s)) for s in shots])
        mean = spectra.mean(axis=0)
        n = shots[0].shape[1]
        smooth = _level(mean) * (math.log(2.0) if len(shots) == 1 else 1.0)
        width = max(1, round(_SMEARED_HZ * n / rate_hz))
        lines = np.where(mean > _threshold(mean.size) * smooth, mean, 0.0)
        return cls(np.maximum(smooth, maximum_filter1d(lines, 2 * width + 1)), n, rate_hz)


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
    spectrum = rfft(_beside_plane(dmdt))
    power = np.abs(spectrum) ** 2 / n
    level = np.maximum(noise.power, _level(power) * math.log(2.0))
    bins = np.arange(power.size) * noise.rate_hz / n
    inside = (bins > _BAND_HZ[0]) & (bins < _BAND_HZ[1])
    out = inside & (power > _threshold(int(inside.sum())) * level)
    width = max(1, round(_BESIDE_HZ * n / noise.rate_hz))
    kept = inside & maximum_filter1d(out, 2 * width + 1)
    size = float(np.max(np.abs(irfft(np.where(kept, spectrum, 0.0), n)), initial=0.0))
    sd = math.sqrt(2.0 * float(np.sum(noise.power[kept])) / n) if out.any() else _unseen_sd(noise, inside, width)
    return ZResidual(size if out.any() else 0.0, sd, _lines(spectrum, kept, bins, n))


def _unseen_sd(noise: ZNoise, inside: np.ndarray, width: int) -> float:
    """Of a line that did not stand out."""
    return math.sqrt(2.0 * float(np.median(noise.power[inside])) * (2 * width + 1) / noise.samples)


def _beside_plane(dmdt: Array) -> Array:
    """z less what leaks into it from x and y, by least squares, (n,)."""
    leak = np.linalg.lstsq(dmdt[:2].T, dmdt[2], rcond=None)[0]
    return np.asarray(dmdt[2] - leak @ dmdt[:2])


def _power(residual: Array) -> Array:
    return np.asarray(np.abs(rfft(residual)) ** 2 / residual.size)


def _level(power: Array) -> Array:
    """Mean of noise in every bin, by medians in bands that lines do not fill."""
    edges = np.unique(np.geomspace(8, power.size, _BANDS).astype(int))
    return np.asarray(median_level(power[None], [0, *edges])[0]) / math.log(2.0)


def _threshold(bins: int) -> float:
    """Times its mean that the power of noise exceeds anywhere in so many bins with the chance stated."""
    return math.log(bins / _FALSE)


def _lines(spectrum: NDArray[np.complex128], kept: np.ndarray, bins: Array, n: int) -> tuple[SideLine, ...]:
    """Runs of kept bins, each at its strongest one."""
    ends = np.flatnonzero(np.diff(np.concatenate([[0], kept.astype(np.int8), [0]])))
    found = []
    for first, last in ends.reshape(-1, 2):
        part = np.zeros_like(spectrum)
        part[first:last] = spectrum[first:last]
        peak = first + int(np.argmax(np.abs(spectrum[first:last])))
        found.append(SideLine(float(bins[peak]), float(np.max(np.abs(irfft(part, n))))))
    return tuple(sorted(found, key=lambda line: -line.size_am2_per_s)[:_MOST_LINES])
