"""Harmonic amplitudes of a few periods: the local, model-free picture that start values are read from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .arrays import Array, ComplexArray
from .line_search import best_frequency, block_means
from .refusal import Refusal, RefusedError

_HARMONICS = 4
_NUMBERS = np.arange(1.0, _HARMONICS + 1.0)
_POINTS_PER_PERIOD = 24
_SEARCH = 0.12
_SETTLED = 0.03  # rad, at the ends of the stretch: what is left of it is of second order


@dataclass(frozen=True)
class Snapshot:
    """Complex harmonic amplitudes at the middle of a stretch: channel c is Re sum_k z[k-1, c] exp(i k W (t - t0)).

    Attributes:
        time_s: the middle t0 of the stretch.
        omega: angular frequency W there, rad/s.
        z: (4, channels) amplitudes of harmonics 1..4 at t0.
        z_sd: (channels,) standard deviation of real and imaginary parts.
        decay_per_s: relative decay rate of the fundamental.
    """

    time_s: float
    omega: float
    z: ComplexArray
    z_sd: Array
    decay_per_s: float


def take_snapshot(y: Array, first: int, last: int, dt_s: float, frequency_hz: float, noise_sd: Array) -> Snapshot:
    """Least-squares harmonics with linearly drifting amplitudes over samples first .. last-1 of y (channels, n).

    The frequency is searched within 12 % (a long spectrum shows the mean of a sweep, not its beginning), then
    refined by the drift of the fundamental's phase.
    """
    block = max(1, int(1.0 / (frequency_hz * dt_s * _POINTS_PER_PERIOD)))
    blocks = (last - first) // block
    data = np.empty((y.shape[0], blocks))
    block_means(y, first, block, blocks, data)
    middle = (first + 0.5 * (block * blocks - 1)) * dt_s
    half = max(0.5 * (blocks - 1) * block, 1.0) * dt_s
    weights = noise_sd**-2.0
    centre = 2.0 * np.pi * frequency_hz
    omega = best_frequency(data, block * dt_s, (1.0 - _SEARCH) * centre, (1.0 + _SEARCH) * centre, weights)
    for _ in range(3):
        z, slope, factor = _drifting_harmonics(data, block * dt_s, omega)
        weighted = weights * z[0].conj()
        overlap = complex(weighted @ slope[0] / (weighted @ z[0]).real)
        omega += overlap.imag / half
        if abs(overlap.imag) < _SETTLED:
            break
    # Block averages attenuate harmonic k by a sinc.
    turn = 0.5 * omega * dt_s * _NUMBERS
    droop = np.sin(block * turn) / (block * np.sin(turn))
    return Snapshot(
        time_s=float(middle),
        omega=omega,
        z=z / droop[:, None],
        z_sd=noise_sd / np.sqrt(block) * factor,
        decay_per_s=-overlap.real / half,
    )


def _drifting_harmonics(data: Array, step_s: float, omega: float) -> tuple[ComplexArray, ComplexArray, float]:
    """Amplitudes and their drifts per half stretch, both (4, channels), and the sd factor of an amplitude."""
    n, blocks = _HARMONICS, data.shape[1]
    middle = 0.5 * (blocks - 1)
    place = np.arange(blocks) - middle
    waves = np.empty((n, blocks), dtype=np.complex128)
    waves[0] = np.exp(1j * omega * step_s * place)
    np.multiply(waves[0], waves[0], out=waves[1])
    np.multiply(waves[:2], waves[1], out=waves[2:])
    columns = np.empty((4 * n + 1, blocks))
    columns[:n], columns[n : 2 * n] = waves.real, -waves.imag
    np.multiply(columns[: 2 * n], place / max(middle, 1.0), out=columns[2 * n : 4 * n])
    columns[4 * n] = 1.0
    try:
        solution = np.linalg.solve(columns @ columns.T, columns @ data.T)
    except np.linalg.LinAlgError as error:
        raise RefusedError(
            Refusal.TOO_SHORT, "the beginning of the window does not tell its harmonics apart"
        ) from error
    z = solution[:n] + 1j * solution[n : 2 * n]
    slope = solution[2 * n : 3 * n] + 1j * solution[3 * n : 4 * n]
    return z, slope, math.sqrt(2.0 / data.shape[1])
