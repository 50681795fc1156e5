"""A second resonator in the same record, told from what else a fit can leave over.

A candidate is a decaying oscillation of any axis and phase, added to the fit in linear approximation, so that what the
fit has already absorbed of it is given back:

    r = J dp + G dg + sum over channels c of (a_c cos(2 pi f2 t) + b_c sin(2 pi f2 t)) exp(-mu t)

J are the fit's own derivatives; G, one complex gain per channel on the fitted motion, is what crosstalk, delays and
gain errors can do. A torque that the model lacks modulates the fitted motion: its two side bands share the misfit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft

from ..numerics.arrays import Array, ComplexArray
from .leftover import Leftover, known_of, noise_of, without

_PADDING = 4  # grid points per resolved frequency step
_BAND = (0.2, 3.5)  # of the fundamental, in which candidates are sought
_DECAYS = (0.0, 1.0, 3.0)  # over the stretch, as exponents
_STRETCHES = 8
_SURE_MISFIT = 10.0  # in standard deviations of the noise's power
_STRETCH_PERIODS = 60.0  # a friction-damped companion changes its frequency over longer stretches


@dataclass(frozen=True)
class Companion:
    """A second oscillation.

    Attributes:
        frequency_hz: of the companion.
        relative: its initial size over that of the fitted signal.
        decay_per_s: its decay.
        seconds: the stretch it was found in.
        share: of the misfit's power that it removes.
        decay_sd_per_s: its standard deviation.
        turns: periods of its beat with the next harmonic of the fitted motion in that stretch.
        harmonic: number of that harmonic.
    """

    frequency_hz: float
    relative: float
    decay_per_s: float
    decay_sd_per_s: float
    seconds: float
    share: float
    turns: float
    harmonic: int


def find_companion(leftover: Leftover) -> Companion | None:
    """The candidate that removes most of the misfit, over the beginning or over the whole window."""
    whole = leftover.scaled.shape[1]
    lengths = sorted({min(whole, int(_STRETCH_PERIODS * leftover.rate_hz / leftover.fundamental_hz)), whole})
    found = [c for n in lengths if (c := _scan(leftover.beginning(n))) is not None]
    return max(found, key=lambda c: c.share, default=None)


def _scan(given: Leftover) -> Companion | None:
    """Best frequency over one stretch."""
    channels, n = given.scaled.shape
    known = known_of(given)
    left = without(given.scaled, known)
    noise = noise_of(left)
    misfit = float(np.sum(left**2)) - noise * left.size
    size = next_fast_len(_PADDING * n, real=True)
    low, high = (int(b * given.fundamental_hz / given.rate_hz * size) for b in _BAND)
    bins = np.arange(max(low, _PADDING), min(high, size // 4))
    if bins.size == 0 or misfit < _SURE_MISFIT * noise * np.sqrt(left.size):
        return None
    gain, k, amplitudes = max((_best(left, known, decay, size, bins) for decay in _DECAYS), key=lambda best: best[0])
    frequency = float(bins[k]) * given.rate_hz / size
    decay, decay_sd = _decay(left, frequency, given.rate_hz, noise)
    harmonic = max(1, round(frequency / given.fundamental_hz))
    return Companion(
        frequency_hz=frequency,
        relative=_relative(amplitudes, given),
        decay_per_s=decay,
        decay_sd_per_s=decay_sd,
        seconds=n / given.rate_hz,
        share=(gain - 2.0 * channels * noise) / misfit,
        turns=abs(frequency - harmonic * given.fundamental_hz) * n / given.rate_hz,
        harmonic=harmonic,
    )


def _best(left: Array, known: Array, decay: float, size: int, bins: np.ndarray) -> tuple[float, int, Array]:
    """Largest fall of chi^2 over the frequencies, the index of the bin, and the amplitudes (2 channels,)."""
    envelope = np.exp(-decay * np.arange(left.shape[1]) / left.shape[1])
    gram = _gram(rfft(envelope**2, size), rfft(known * envelope, size, axis=-1)[..., bins], bins)
    right = _real(rfft(left * envelope, size, axis=-1)[:, bins])
    amplitudes = np.linalg.solve(gram, right[..., None])[..., 0]
    gain = np.sum(amplitudes * right, axis=1)
    k = int(np.argmax(gain))
    return float(gain[k]), k, amplitudes[k]


def _relative(amplitudes: Array, given: Leftover) -> float:
    """Size of an oscillation with these amplitudes (2 channels,) over that of the fitted signal at its beginning."""
    early = given.motion[:, : max(8, given.motion.shape[1] // 16)] * given.sd[:, None]
    main = float(np.sqrt(2.0 * np.mean(early**2, axis=1).sum()))
    return float(np.linalg.norm(amplitudes * np.tile(given.sd, 2))) / main


def _decay(left: Array, frequency_hz: float, rate_hz: float, noise: float) -> tuple[float, float]:
    """Decay in 1/s of the line at this frequency and its standard deviation, from its size in eight stretches."""
    n = left.shape[1] // _STRETCHES
    wave = np.exp(-2j * np.pi * frequency_hz / rate_hz * np.arange(n * _STRETCHES))
    sizes = np.linalg.norm((left[:, : wave.size] * wave).reshape(left.shape[0], _STRETCHES, n).mean(axis=2), axis=0)
    sd = np.sqrt(noise / (2.0 * n)) / np.maximum(sizes, 1e-300)
    time = (np.arange(_STRETCHES) + 0.5) * n / rate_hz
    (slope, _), covariance = np.polyfit(time, np.log(np.maximum(sizes, 1e-300)), 1, w=1.0 / sd, cov="unscaled")
    return -float(slope), float(np.sqrt(covariance[0, 0]))


def _real(transform: ComplexArray) -> Array:
    """Scalar products with cos and sin per channel, (bins, 2 channels), from transforms (channels, bins)."""
    return np.concatenate([transform.real, -transform.imag]).T


def _gram(squared: ComplexArray, known: ComplexArray, bins: np.ndarray) -> Array:
    """Scalar products of the candidate's columns without what is known of them, (bins, 2 channels, 2 channels).

    squared: transform of the envelope's square; known: transforms (k, channels, bins) of the known times the envelope.
    """
    channels = known.shape[1]
    eye = np.eye(channels)
    at_twice = squared[2 * bins][:, None, None]
    cos2, sin2 = (0.5 * (squared[0].real + sign * at_twice.real) * eye for sign in (1.0, -1.0))
    both = -0.5 * at_twice.imag * eye
    gram = np.concatenate(
        [np.concatenate([cos2, both], axis=2), np.concatenate([both, sin2], axis=2)], axis=1
    )  # fmt: skip
    columns = np.stack([_real(row) for row in known], axis=2)
    gram = gram - columns @ columns.transpose(0, 2, 1)
    return np.asarray(gram + 1e-3 * squared[0].real * np.eye(2 * channels))
