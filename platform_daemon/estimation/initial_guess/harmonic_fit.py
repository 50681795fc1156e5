"""Harmonic amplitudes of a few periods: the local, model-free picture that start values are read from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array, ComplexArray
from platform_daemon.estimation.numerics.jit import fast_kernel
from platform_daemon.estimation.numerics.linear_systems import factorise, substitute
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.screening.frequency_search import best_frequency, block_means
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.start_values


@dataclass(frozen=True, kw_only=True)
class HarmonicFit:
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


def fit_harmonics(y: Array, *, first: int, last: int, dt_s: float, frequency_hz: float, noise_sd: Array) -> HarmonicFit:
    """Least-squares harmonics with linearly drifting amplitudes over samples first .. last-1 of y (channels, n).

    The frequency is refined by the drift of the fundamental's phase. Where that is too large (a long spectrum shows
    the mean of a sweep, not its beginning), it is searched within 12 % first.
    """
    block = max(1, int(1.0 / (frequency_hz * dt_s * LIMITS.points_per_period)))
    blocks = (last - first) // block
    data = block_means(y, first, block, blocks)
    middle = (first + 0.5 * (block * blocks - 1)) * dt_s
    half = max(0.5 * (blocks - 1) * block, 1.0) * dt_s
    weights = noise_sd**-2.0
    omega = 2.0 * np.pi * frequency_hz
    found = (
        _refined(data, block * dt_s, omega, weights, half, LIMITS.near_phase_rad)
        if LIMITS.frequency_search_share * omega * half < LIMITS.told_phase_rad
        else None
    )
    if found is None:
        omega = best_frequency(
            data,
            step_s=block * dt_s,
            lowest=(1.0 - LIMITS.frequency_search_share) * omega,
            highest=(1.0 + LIMITS.frequency_search_share) * omega,
            weights=weights,
        )
        found = _refined(data, block * dt_s, omega, weights, half, math.inf)
        assert found is not None
    omega, drift, z, factor = found
    # Block averages attenuate harmonic k by a sinc.
    turns = [0.5 * omega * dt_s * k for k in range(1, LIMITS.harmonics + 1)]
    rise = np.array([block * math.sin(turn) / math.sin(block * turn) for turn in turns])
    return HarmonicFit(
        time_s=middle,
        omega=omega,
        z=z * rise[:, None],
        z_sd=noise_sd / math.sqrt(block) * factor,
        decay_per_s=-drift / half,
    )


def _refined(
    data: Array, step_s: float, omega: float, weights: Array, half_s: float, near: float
) -> tuple[float, float, ComplexArray, float] | None:
    """Angular frequency, relative drift of the fundamental over half the stretch, amplitudes, the sd factor of one.

    None if its phase drifts by more than `near`, in rad over half the stretch, at the given frequency.
    """
    for _ in range(LIMITS.frequency_rounds):
        z, slope, factor = _drifting_harmonics(data, step_s, omega)
        fundamental = list(zip(weights.tolist(), z[0].tolist(), slope[0].tolist(), strict=True))
        power = sum(weight * abs(one) ** 2 for weight, one, _ in fundamental)
        if power == 0.0:
            raise RefusedError(Refusal.NO_SIGNAL, "the beginning of the window is silent")
        overlap = sum(weight * one.conjugate() * drift for weight, one, drift in fundamental) / power
        if abs(overlap.imag) > near:
            return None
        omega += overlap.imag / half_s
        if abs(overlap.imag) < LIMITS.settled_phase_rad:
            break
    return omega, overlap.real, z, factor


def _drifting_harmonics(data: Array, step_s: float, omega: float) -> tuple[ComplexArray, ComplexArray, float]:
    """Amplitudes and their drifts per half stretch, both (4, channels), and the sd factor of an amplitude."""
    channels, blocks = data.shape
    n = _unfolded(2.0 * math.pi / (omega * step_s), blocks)
    solution = np.empty((channels, 4 * n + 1))
    if not _harmonic_least_squares(data, omega * step_s, solution):
        raise RefusedError(Refusal.TOO_SHORT, "the beginning of the window does not tell its harmonics apart")
    parts = np.zeros((LIMITS.harmonics, 4, channels))
    parts[:n] = solution[:, : 4 * n].reshape(channels, 4, n).T
    return parts[:, 0] + 1j * parts[:, 1], parts[:, 2] + 1j * parts[:, 3], math.sqrt(2.0 / blocks)


def _unfolded(per_period: float, points: int) -> int:
    """How many harmonics, four at most, can be separated from each other and from their mirrors at the sampling rate.

    per_period: points in a period; harmonics j and k meet where j + k is the number of points in a period.
    """
    apart = LIMITS.harmonics_apart_bins * per_period / points
    for n in range(LIMITS.harmonics, LIMITS.fewest_harmonics, -1):
        if all(abs(per_period - both) > apart for both in range(2, 2 * n + 1)):
            return n
    return LIMITS.fewest_harmonics


@fast_kernel
def _harmonic_least_squares(data, turn, solution):  # type: ignore[no-untyped-def]
    """Least squares of data (channels, n) with cos k x, -sin k x, both times the place in -1 .. 1, and 1: k = 1..4.

    x advances by `turn` per point and is 0 in the middle. solution (channels, 17); False if they cannot be separated.
    """
    n = data.shape[1]
    size = solution.shape[1]
    harmonics = size // 4
    middle = 0.5 * (n - 1)
    columns = np.empty((size, n))
    for i in range(n):
        cosine = math.cos(turn * (i - middle))
        sine = math.sin(turn * (i - middle))
        real = 1.0
        imaginary = 0.0
        place = (i - middle) / max(middle, 1.0)
        for k in range(harmonics):
            real, imaginary = real * cosine - imaginary * sine, real * sine + imaginary * cosine
            columns[k, i] = real
            columns[harmonics + k, i] = -imaginary
            columns[2 * harmonics + k, i] = place * real
            columns[3 * harmonics + k, i] = -place * imaginary
        columns[size - 1, i] = 1.0
    gram = np.empty((size, size))
    order = np.empty(size, dtype=np.int64)
    for p in range(size):
        for q in range(p + 1):
            total = 0.0
            for i in range(n):
                total += columns[p, i] * columns[q, i]
            gram[p, q] = gram[q, p] = total
    if not factorise(gram, order):
        return False
    for channel in range(data.shape[0]):
        for p in range(size):
            total = 0.0
            for i in range(n):
                total += columns[p, i] * data[channel, i]
            solution[channel, p] = total
        substitute(gram, order, solution[channel])
    return True
