"""The undamped orbit of the magnetic pendulum (equ:ODE_norm) in closed form: frequency and harmonic amplitudes.

With k = sin(A/2), K = K(k) and the nome q = exp(-pi K'/K), counted from the turning point phi = +A:
    d(sin phi)/dt = -sum over odd n of v_n sin(n W t),   v_n ~ n^2 q^(n/2) / (1 + q^n)
    d(cos phi)/dt = +sum over even n of u_n sin(n W t),  u_2 / v_1 = 4 sqrt(q) / (1 - q)
"""

from __future__ import annotations

import math

from scipy.special import ellipk, ellipkm1

from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.physics


def nome(amplitude_rad: float) -> float:
    """The nome q of the orbit with this amplitude, 0 < A < pi."""
    m = math.sin(0.5 * amplitude_rad) ** 2
    return math.exp(-math.pi * float(ellipkm1(m)) / float(ellipk(m)))


def amplitude_from_nome(q: float) -> float:
    """Amplitude in rad: k = (theta_2(q) / theta_3(q))^2 and A = 2 asin(k)."""
    theta2 = 2.0 * q**0.25 * sum(q ** (n * (n + 1)) for n in range(LIMITS.theta_terms))
    theta3 = 1.0 + 2.0 * sum(q ** (n * n) for n in range(1, LIMITS.theta_terms))
    return 2.0 * math.asin(min(1.0, (theta2 / theta3) ** 2))


def amplitude_from_second_harmonic(ratio: float) -> float:
    """Amplitude in rad from u_2/v_1 >= 0 (inverts 4 sqrt(q) / (1 - q))."""
    if ratio <= 0.0:
        return 0.0
    root_q = (math.sqrt(4.0 + ratio * ratio) - 2.0) / ratio
    return amplitude_from_nome(root_q * root_q)


def amplitude_from_third_harmonic(ratio: float) -> float:
    """Amplitude in rad from v_3/v_1 = 9 q (1 + q) / (1 + q^3) >= 0, by fixed-point iteration."""
    if ratio <= 0.0:
        return 0.0
    q = 0.0
    for _ in range(LIMITS.nome_rounds):
        q = min(ratio * (1.0 + q**3) / (9.0 * (1.0 + q)), LIMITS.nome_most)
    return amplitude_from_nome(q)


def frequency_ratio(amplitude_rad: float) -> float:
    """Frequency of the orbit over the natural frequency, pi / (2 K)."""
    return math.pi / (2.0 * float(ellipk(math.sin(0.5 * amplitude_rad) ** 2)))


def first_harmonic(amplitude_rad: float) -> float:
    """v_1 over w: pi^3 sqrt(q) / ((1 + q) K^3); tends to A for small A."""
    q = nome(amplitude_rad)
    k = float(ellipk(math.sin(0.5 * amplitude_rad) ** 2))
    return math.pi**3 * math.sqrt(q) / ((1.0 + q) * k**3)
