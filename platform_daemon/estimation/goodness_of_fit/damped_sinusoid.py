"""A decaying oscillation in what a fit leaves over, with the frequency and decay that explain most of it.

Every channel sees it with an amplitude and phase of its own, with time t over a stretch of length T:

    Re a_c exp(2 pi i f t - mu t + (i chirp - bend) t^2 / T)

Chirp and bend are what friction does to a resonator: it swings the faster and loses the larger share the smaller it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array, ComplexArray
from platform_daemon.estimation.thresholds import THRESHOLDS

from .residual_jacobian import LinearisedResidual, fitted_subspace, noise_power, projected_out

LIMITS = THRESHOLDS.goodness_of_fit
_FURTHEST = np.array(LIMITS.sinusoid_furthest)


@dataclass(frozen=True)
class ProjectedResidual:
    """A residual without what the fit and a gain per channel can move.

    Attributes:
        given: what it comes from.
        known: (k, channels, n) orthonormal basis of what can be moved.
        left: (channels, n) the rest.
    """

    given: LinearisedResidual
    known: Array
    left: Array

    @property
    def seconds(self) -> float:
        """Length of the stretch."""
        return self.left.shape[1] / self.given.rate_hz

    def clear(self, rows: Array) -> Array:
        """Rows (k, channels, n) without what is known, flat: (k, channels n)."""
        return np.stack([projected_out(row, self.known).ravel() for row in rows])


@dataclass(frozen=True, kw_only=True)
class DampedSinusoid:
    """An oscillation: shape (frequency in Hz; decay, chirp, bend in 1/s), and how well it is known.

    Attributes:
        shape: (4,).
        sd: (4,) standard deviations of the shape; 0: not estimated.
        gain: fall of chi^2.
        noise: power in a point of what is left then.
    """

    shape: Array
    sd: Array
    gain: float
    noise: float


def projected_residual(given: LinearisedResidual) -> ProjectedResidual:
    """Take out what the fit can move."""
    known = fitted_subspace(given)
    return ProjectedResidual(given, known, projected_out(given.scaled, known))


def carrier(shape: Array, n: int, rate_hz: float) -> tuple[ComplexArray, Array]:
    """The oscillation of size 1 at the beginning, (n,), and the derivatives of its logarithm by its shape, (4, n)."""
    time = np.arange(n) / rate_hz
    bent = time * time * rate_hz / n
    derivatives = np.stack([2j * np.pi * time, -time, 1j * bent, -bent])
    return np.exp(shape @ derivatives), derivatives


def columns(wave: ComplexArray, channels: int) -> Array:
    """Its cosine and sine in every channel, (2 channels, channels, n)."""
    eye = np.eye(channels)[:, :, None]
    return np.concatenate([eye * wave.real, eye * -wave.imag])


def refine_sinusoid(
    cleared: ProjectedResidual, frequency_hz: float, decay_per_s: float
) -> tuple[DampedSinusoid, DampedSinusoid]:
    """The best wave from a start value: with an exponential decay at one frequency, and with chirp and bend."""
    start = DampedSinusoid(shape=np.array([frequency_hz, decay_per_s, 0.0, 0.0]), sd=np.zeros(4), gain=0.0, noise=1.0)
    plain = _climbed(cleared, start, 2)
    return plain, _climbed(cleared, plain, 4)


def _climbed(cleared: ProjectedResidual, start: DampedSinusoid, free: int) -> DampedSinusoid:
    """Gauss-Newton on the first `free` numbers of the shape, as long as chi^2 falls; amplitudes are solved for."""
    best, shape = replace(start, gain=-np.inf), start.shape
    for _ in range(LIMITS.sinusoid_steps):
        wave, step = _stepped(cleared, shape, free)
        if wave.gain > best.gain:
            worth = wave.gain > (1.0 + LIMITS.sinusoid_gain_share) * best.gain
            best, shape = wave, shape + np.clip(step, -_FURTHEST / cleared.seconds, _FURTHEST / cleared.seconds)
            if worth:
                continue
        break
    return best


def _stepped(cleared: ProjectedResidual, shape: Array, free: int) -> tuple[DampedSinusoid, Array]:
    """The wave of this shape with its best amplitudes, and the step that would improve it, (4,)."""
    channels, n = cleared.left.shape
    signal = cleared.left.ravel()
    carried, derivatives = carrier(shape, n, cleared.given.rate_hz)
    rows = cleared.clear(columns(carried, channels))
    amplitudes = np.linalg.lstsq(rows.T, signal, rcond=None)[0]
    explained = amplitudes @ rows
    seen = (amplitudes[:channels] + 1j * amplitudes[channels:])[:, None] * carried
    every = np.concatenate([rows, cleared.clear((seen * derivatives[:free, None]).real)])
    moves = np.linalg.lstsq(every.T, signal, rcond=None)[0]
    noise = noise_power(cleared.left - explained.reshape(channels, n))
    step, sd = np.zeros(4), np.zeros(4)
    step[:free] = moves[2 * channels :]
    sd[:free] = np.sqrt(noise * np.linalg.pinv(every @ every.T).diagonal()[2 * channels :])
    return DampedSinusoid(shape=shape, sd=sd, gain=float(signal @ explained), noise=noise), step
