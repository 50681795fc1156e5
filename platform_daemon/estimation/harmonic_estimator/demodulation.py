"""Demodulation of a stretch of ring-down along the phase of a damped orbit: frequency, amplitude and their rates."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array, ComplexArray
from platform_daemon.estimation.physics.orbit import (
    amplitude_from_second_harmonic,
    first_harmonic,
    frequency_ratio,
    nome,
)
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.harmonic_estimator


class DemodulatedStretch:
    """Samples with two windows over them; time counts from the middle."""

    def __init__(self, samples: Array, dt_s: float) -> None:
        count = samples.shape[1]
        length = int(LIMITS.window_share * count)
        self.samples = samples - samples.mean(axis=1, keepdims=True)
        self.time = (np.arange(count) - 0.5 * (count - 1)) * dt_s
        self.apart_s = (count - length) * dt_s
        self.length_s = count * dt_s
        self._length = length
        self._window = np.kaiser(length, LIMITS.kaiser_beta)
        self._window *= 2.0 / self._window.sum()
        own = np.average((np.arange(length) - 0.5 * (length - 1)) ** 2, weights=self._window) * dt_s**2
        # Times at which the mean of two values is the mean over both windows, for amplitudes and for the frequency.
        self.spread_s = math.sqrt(0.25 * self.apart_s**2 + own)
        self.phase_spread_s = math.sqrt(0.25 * self.apart_s**2 / 3.0 + own)

    def demodulated(self, omega: float, chirp: float, orders: tuple[float, ...]) -> ComplexArray:
        """Complex amplitudes (2 windows, orders, channels) against the phase omega t + chirp t^2 / 2."""
        phase = omega * self.time + 0.5 * chirp * self.time**2
        waves = np.exp(-1j * np.outer(orders, phase))
        n = self._length
        first = (waves[:, :n] * self._window) @ self.samples[:, :n].T
        last = (waves[:, -n:] * self._window) @ self.samples[:, -n:].T
        return np.stack([first, last])


@dataclass(frozen=True, kw_only=True)
class Orbit:
    """Frequency (rad/s), its rate (rad/s^2), amplitude (rad) and its rate (rad/s) in the middle of a stretch."""

    omega: float
    chirp: float
    amplitude: float
    slope: float


@dataclass(frozen=True)
class Waves:
    """Real channel vectors of v_1 and u_2, (2 windows, channels) each."""

    v: Array
    u: Array


def aligned(z: ComplexArray) -> Waves:
    """Vectors along the common phase: with Theta since the turning point +A, v ~ -sin(Theta), u ~ +sin(2 Theta)."""
    first, second = z[:, 0], z[:, 1]
    common = 0.5 * float(np.angle(np.sum(first**2)))
    theta = common - 0.5 * math.pi
    return Waves((first * np.exp(-1j * common)).real, (second * 1j * np.exp(-2j * theta)).real)


def improved(stretch: DemodulatedStretch, orbit: Orbit) -> Orbit:
    """One pass: demodulate along the known phase, correct frequency, amplitude and their rates."""
    z = stretch.demodulated(orbit.omega, orbit.chirp, (1.0, 2.0))
    omega = orbit.omega + float(np.angle(np.sum(np.conj(z[0, 0]) * z[1, 0]))) / stretch.apart_s
    waves = aligned(z)
    v, u = np.linalg.norm(waves.v, axis=1), np.linalg.norm(waves.u, axis=1)
    amplitude = _amplitude(float(u.sum() / v.sum()), orbit, stretch.spread_s)
    slope = _amplitude_change(amplitude, v, u) / stretch.apart_s
    chirp = omega * _log_slope(frequency_ratio, amplitude) * slope
    return Orbit(omega=omega, chirp=chirp, amplitude=amplitude, slope=slope)


def averaged(function: Callable[[float], float], orbit: Orbit, spread_s: float) -> float:
    """Mean of a function of the amplitude over the windows, exact to third order of its way there."""
    way = min(abs(orbit.slope) * spread_s, LIMITS.averaging_share * orbit.amplitude)
    return 0.5 * (function(orbit.amplitude - way) + function(orbit.amplitude + way))


def _amplitude(ratio: float, orbit: Orbit, spread_s: float) -> float:
    """A from the ratio of the mean u_2 to the mean v_1; what averaging does to it is known from the last pass."""
    if orbit.amplitude == 0.0:
        return amplitude_from_second_harmonic(ratio)
    mean = averaged(second_harmonic, orbit, spread_s) / averaged(first_harmonic, orbit, spread_s)
    exact = second_harmonic(orbit.amplitude) / first_harmonic(orbit.amplitude)
    return amplitude_from_second_harmonic(ratio * exact / mean)


def _amplitude_change(amplitude: float, v: Array, u: Array) -> float:
    """Change of A between the windows, from the changes of ln v_1 and ln u_2, each weighted by its power.

    The fundamental alone saturates at large angles, the second harmonic alone is weak at small ones.
    """
    by_v = _log_slope(first_harmonic, amplitude)
    by_u = _log_slope(second_harmonic, amplitude)
    weights = float(v.sum()) ** 2 * by_v, float(u.sum()) ** 2 * by_u
    change = weights[0] * math.log(v[1] / v[0]) + weights[1] * math.log(u[1] / u[0])
    return change / (weights[0] * by_v + weights[1] * by_u)


def second_harmonic(amplitude_rad: float) -> float:
    """u_2 over omega_nat: 4 sqrt(q) / (1 - q) of v_1."""
    q = nome(amplitude_rad)
    return 4.0 * math.sqrt(q) / (1.0 - q) * first_harmonic(amplitude_rad)


def _log_slope(function: Callable[[float], float], amplitude_rad: float) -> float:
    """d ln(function) / dA by a central difference."""
    step = LIMITS.slope_step_share * amplitude_rad
    return math.log(function(amplitude_rad + step) / function(amplitude_rad - step)) / (2.0 * step)
