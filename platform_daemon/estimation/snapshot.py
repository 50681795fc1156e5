"""Harmonic amplitudes of a few periods: the local, model-free picture that start values are read from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import Array, ComplexArray

_HARMONICS = 4
_POINTS_PER_PERIOD = 40
_SEARCH = np.linspace(-0.12, 0.12, 49)


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
    data = y[:, first : first + blocks * block].reshape(y.shape[0], blocks, block).mean(axis=2)
    time = (first + 0.5 * (block - 1) + block * np.arange(blocks)) * dt_s
    middle = 0.5 * (time[0] + time[-1])
    half = max(0.5 * (time[-1] - time[0]), dt_s)
    omegas = 2.0 * np.pi * frequency_hz * (1.0 + _SEARCH)
    weights = noise_sd**-2.0
    powers = [_explained(data, time - middle, omega, weights) for omega in omegas]
    omega = float(omegas[int(np.argmax(powers))])
    for _ in range(4):
        z, slope, factor = _drifting_harmonics(data, time - middle, omega, half)
        overlap = np.sum(weights * np.conj(z[0]) * slope[0]) / np.sum(weights * np.abs(z[0]) ** 2)
        omega += float(overlap.imag) / half
    # Block averages attenuate harmonic k by a sinc.
    droop = np.sinc(0.5 * np.arange(1, _HARMONICS + 1) * omega * block * dt_s / np.pi)
    if block > 1:
        droop = droop / np.sinc(0.5 * np.arange(1, _HARMONICS + 1) * omega * dt_s / np.pi)
    return Snapshot(
        time_s=float(middle),
        omega=omega,
        z=z / droop[:, None],
        z_sd=noise_sd / np.sqrt(block) * factor,
        decay_per_s=-float(overlap.real) / half,
    )


def _explained(data: Array, time: Array, omega: float, weights: Array) -> float:
    """Weighted power explained by harmonics 1 and 2 with constant amplitudes."""
    phase = omega * time
    design = np.column_stack([np.cos(phase), np.sin(phase), np.cos(2 * phase), np.sin(2 * phase)])
    projected = design.T @ data.T
    solution = np.linalg.lstsq(design.T @ design, projected, rcond=None)[0]
    return float(np.sum(weights * np.sum(projected * solution, axis=0)))


def _drifting_harmonics(
    data: Array, time: Array, omega: float, half: float
) -> tuple[ComplexArray, ComplexArray, float]:
    """Amplitudes and their drifts per half stretch, both (4, channels), and the sd factor of an amplitude."""
    k = np.arange(1, _HARMONICS + 1)
    wave = np.exp(1j * np.outer(time, k) * omega)
    drift = wave * (time / half)[:, None]
    design = np.hstack([wave.real, -wave.imag, drift.real, -drift.imag, np.ones((time.size, 1))])
    solution = np.linalg.lstsq(design, data.T, rcond=None)[0]
    n = _HARMONICS
    z = solution[:n] + 1j * solution[n : 2 * n]
    slope = solution[2 * n : 3 * n] + 1j * solution[3 * n : 4 * n]
    return z, slope, float(np.sqrt(2.0 / time.size))
