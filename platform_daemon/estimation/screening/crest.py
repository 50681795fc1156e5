"""How far the peaks of a waveform stand above its root mean square."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array, ComplexArray
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.screening


def crest_factor(signal: Array, *, centre: int, rate_hz: float, frequency_hz: float) -> float | None:
    """Largest value over rms of a channel (n,) around a sample, from its harmonics, so that noise does not count.

    frequency_hz: nearly that of the waveform there.  None where there are too few periods or samples in a period.
    """
    step = max(1, int(rate_hz / (LIMITS.crest_points_per_period * frequency_hz)))
    per_period = rate_hz / (step * frequency_hz)
    half = int(0.5 * LIMITS.crest_periods * per_period) * step
    stretch = signal[max(0, centre - half) : centre + half]
    y = stretch[: stretch.size // step * step].reshape(-1, step).mean(axis=1)
    count = min(LIMITS.crest_harmonics, int(per_period / LIMITS.crest_points_per_harmonic))
    if y.size < 0.5 * LIMITS.crest_periods * per_period or count < 2:
        return None
    sizes = _harmonics(y - y.sum() / y.size, 2.0 * math.pi / per_period, count)
    # The means over `step` samples take that much off each harmonic.
    sizes /= np.sinc(np.arange(1, count + 1) / per_period)
    power = 0.5 * float(np.vdot(sizes, sizes).real)
    return float(np.abs((_curve()[:, :count] @ sizes).real).max()) / math.sqrt(power) if power > 0.0 else None


def _harmonics(y: Array, step_rad: float, count: int) -> ComplexArray:
    """Complex sizes (count,) of the harmonics of samples (n,) whose fundamental turns by about so much per sample."""
    wave = _turning(y.size, _put_right(y, step_rad))
    waves = np.cumprod(np.broadcast_to(wave, (count, y.size)), axis=0)
    design = np.concatenate([waves.real, waves.imag, np.ones((1, y.size))])
    found = np.linalg.solve(design @ design.T, design @ y)
    return np.asarray(found[:count] - 1j * found[count : 2 * count])


def _put_right(y: Array, step_rad: float) -> float:
    """The turn per sample from how the phase of the fundamental runs away between the two halves."""
    half = y.size // 2
    turned = (y[: 2 * half] * _turning(2 * half, -step_rad)).reshape(2, half).sum(axis=1)
    return step_rad + float(np.angle(turned[1] * turned[0].conjugate())) / half


def _turning(n: int, step_rad: float) -> ComplexArray:
    """exp(i step k), (n,)."""
    return np.exp(1j * step_rad * np.arange(n))


@lru_cache(1)
def _curve() -> ComplexArray:
    """One period of every harmonic, (points, harmonics)."""
    return np.exp(
        2j
        * math.pi
        * np.outer(
            np.arange(LIMITS.crest_curve_points) / LIMITS.crest_curve_points, np.arange(1, LIMITS.crest_harmonics + 1)
        )
    )
