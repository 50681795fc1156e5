"""A second resonator in the same record, distinguished from everything else that a fit can leave over.

A candidate is a decaying oscillation of any axis and phase, added to the fit in linear approximation, so that what the
fit has already absorbed of it is given back:

    r = J dp + G dg + sum over channels c of (a_c cos(2 pi f2 t) + b_c sin(2 pi f2 t)) exp(-mu t)

J are the fit's own derivatives; G, one complex gain per channel on the fitted motion, is what crosstalk, delays and
gain errors can do. A torque that the model lacks modulates the fitted motion: its two side bands share the misfit.
The best candidate of a grid is sharpened (wave), and then fitted together with all parameters (alongside).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft

from platform_daemon.estimation.numerics.arrays import Array, ComplexArray
from platform_daemon.estimation.thresholds import THRESHOLDS

from .damped_sinusoid import DampedSinusoid, ProjectedResidual, carrier, projected_residual, refine_sinusoid
from .omitted_component import ParameterShift, fit_with_component
from .residual_jacobian import LinearisedResidual, noise_power, phase_of

LIMITS = THRESHOLDS.goodness_of_fit


@dataclass(frozen=True, kw_only=True)
class SecondOscillation:
    """A second oscillation.

    Attributes:
        frequency_hz: of the companion.
        relative: its initial size over that of the fitted signal, what the fit has absorbed of it included.
        decay_per_s, decay_sd_per_s: its decay and the standard deviation of that.
        seconds: the stretch it was found in.
        share: of the misfit's power that it removes.
        plain_share: the same if it keeps its frequency and decays exponentially.
        turns: periods of its beat with the next harmonic of the fitted motion in that stretch.
        harmonic: number of that harmonic.
        moves: published parameters, and how far they move if it is fitted with them.
    """

    frequency_hz: float
    relative: float
    decay_per_s: float
    decay_sd_per_s: float
    seconds: float
    share: float
    plain_share: float
    turns: float
    harmonic: int
    moves: tuple[ParameterShift, ...]


@dataclass(frozen=True, kw_only=True)
class _Candidate:
    """The best of a grid: a stretch, frequency and decay, and the share of the misfit that it removes."""

    cleared: ProjectedResidual
    frequency_hz: float
    decay_per_s: float
    share: float


def find_second_oscillation(leftover: LinearisedResidual) -> SecondOscillation | None:
    """The candidate that removes most of the misfit, over the beginning or over the whole window."""
    whole = leftover.scaled.shape[1]
    short, usual = (
        min(whole, int(p * leftover.rate_hz / leftover.fundamental_hz)) for p in LIMITS.candidate_stretch_periods
    )
    best = _best_of(leftover, {usual, whole})
    if best is not None and best.share < LIMITS.whole_stretch_share:
        best = _best_of(leftover, {short}) or best
    return None if best is None else _second_oscillation(best)


def _best_of(leftover: LinearisedResidual, lengths: Iterable[int]) -> _Candidate | None:
    """The candidate with the largest share over stretches of these lengths."""
    found = [c for n in sorted(lengths) if (c := _scan(projected_residual(leftover.beginning(n)))) is not None]
    return max(found, key=lambda c: c.share, default=None)


def _second_oscillation(candidate: _Candidate) -> SecondOscillation | None:
    """The candidate with its frequency and decay sharpened, and what the fit would do with it; None: no oscillation."""
    at = candidate.cleared
    plain, wave = refine_sinusoid(at, candidate.frequency_hz, candidate.decay_per_s)
    frequency = float(wave.shape[0])
    if np.pi * frequency < LIMITS.least_quality * (wave.shape[1] + wave.shape[3]) or frequency < 0.0:
        return None
    harmonic = max(1, round(frequency / at.given.fundamental_hz))
    beside = fit_with_component(at.given, wave)
    return SecondOscillation(
        frequency_hz=frequency,
        relative=beside.relative,
        decay_per_s=float(plain.shape[1]),
        decay_sd_per_s=float(plain.sd[1]),
        seconds=at.seconds,
        share=_share(at, wave.gain, wave.noise),
        plain_share=_share(at, plain.gain, plain.noise),
        turns=_turns(at.given, wave, harmonic),
        harmonic=harmonic,
        moves=beside.moves,
    )


def _share(at: ProjectedResidual, gain: float, noise: float) -> float:
    """Of the misfit's power that falls away; noise: power in a point."""
    return (gain - 2.0 * at.left.shape[0] * noise) / (float(np.sum(at.left**2)) - noise * at.left.size)


def _turns(given: LinearisedResidual, wave: DampedSinusoid, harmonic: int) -> float:
    """Periods of the beat of a wave with a harmonic of the fitted motion, over the whole stretch."""
    n = given.scaled.shape[1]
    carried, _ = carrier(wave.shape, n, given.rate_hz)
    beat = np.unwrap(np.angle(carried)) - harmonic * phase_of(given)
    inner = beat[n // LIMITS.phase_ends_divisor : n - n // LIMITS.phase_ends_divisor]
    return float(np.ptp(inner)) / (2.0 * np.pi) * n / inner.size


def _scan(at: ProjectedResidual) -> _Candidate | None:
    """Best frequency over one stretch."""
    given, left = at.given, at.left
    n = left.shape[1]
    noise = noise_power(left)
    misfit = float(np.sum(left**2)) - noise * left.size
    size = next_fast_len(LIMITS.candidate_padding * n, real=True)
    low, high = (int(b * given.fundamental_hz / given.rate_hz * size) for b in LIMITS.candidate_band)
    bins = np.arange(max(low, LIMITS.candidate_padding), min(high, size // 2 - LIMITS.candidate_padding))
    if bins.size == 0 or misfit < LIMITS.misfit_sigma * noise * np.sqrt(left.size):
        return None
    gain, k, decay = max((*_best(left, at.known, d, size, bins), d) for d in LIMITS.candidate_decays)
    return _Candidate(
        cleared=at,
        frequency_hz=float(bins[k]) * given.rate_hz / size,
        decay_per_s=decay / at.seconds,
        share=_share(at, gain, noise),
    )


def _best(left: Array, known: Array, decay: float, size: int, bins: np.ndarray) -> tuple[float, int]:
    """Largest fall of chi^2 over the frequencies, and the index of the bin."""
    envelope = np.exp(-decay * np.arange(left.shape[1]) / left.shape[1])
    gram = _gram(_at_twice(envelope**2, size, bins), rfft(known * envelope, size, axis=-1)[..., bins])
    right = _real(rfft(left * envelope, size, axis=-1)[:, bins])
    amplitudes = np.linalg.solve(gram, right[..., None])[..., 0]
    gain = np.sum(amplitudes * right, axis=1)
    k = int(np.argmax(gain))
    return float(gain[k]), k


def _real(transform: ComplexArray) -> Array:
    """Scalar products with cos and sin per channel, (bins, 2 channels), from transforms (channels, bins)."""
    return np.concatenate([transform.real, -transform.imag]).T


def _at_twice(envelope: Array, size: int, bins: np.ndarray) -> ComplexArray:
    """Transform of an envelope at frequency 0 and at twice the frequencies of the bins, (1 + bins,).

    Beyond the middle of the band twice a frequency is folded back.
    """
    transform = rfft(envelope, size)
    twice = 2 * bins
    folded = twice > size // 2
    there = transform[np.where(folded, size - twice, twice)]
    return np.concatenate([transform[:1], np.where(folded, np.conj(there), there)])


def _gram(squared: ComplexArray, known: ComplexArray) -> Array:
    """Scalar products of the candidate's columns without what is known of them, (bins, 2 channels, 2 channels).

    squared: transform (1 + bins,) of the envelope's square (_at_twice); known: transforms (k, channels, bins) of the
    known times the envelope.
    """
    channels = known.shape[1]
    eye = np.eye(channels)
    total = squared[0].real
    at_twice = squared[1:, None, None]
    cos2, sin2 = (0.5 * (total + sign * at_twice.real) * eye for sign in (1.0, -1.0))
    both = -0.5 * at_twice.imag * eye
    gram = np.concatenate(
        [np.concatenate([cos2, both], axis=2), np.concatenate([both, sin2], axis=2)], axis=1
    )  # fmt: skip
    columns = np.stack([_real(row) for row in known], axis=2)
    gram = gram - columns @ columns.transpose(0, 2, 1)
    return np.asarray(gram + LIMITS.candidate_regularisation * total * np.eye(2 * channels))
