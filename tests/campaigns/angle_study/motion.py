"""The parameters of a motion, and its trajectory by fixed steps of order 8: quick, for the fits.

phi'' = -w(t)^2 (sin phi + k phi^3) - 2 lambda phi' - c |phi'| phi' - d phi^2 phi' - T (1 + a g(|phi'|)) sgn phi' + b
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.integrate import DOP853

Array = NDArray[np.float64]
NAMES = (
    "f_hz", "lambda", "phi", "v", "offset", "coulomb", "excess", "speed", "law", "quadratic", "angle_damping", "cubic",
    "bias", "drift", "drift_tau", "kick", "kick_s", "zero", "zero_tau", "mode_cos", "mode_sin", "mode_hz", "mode_tau",
)  # fmt: skip
"""f_hz: of small swings. law of the excess friction: 0 exponential, 1 Gaussian, 2 hyperbolic. drift: relative, 1/s or,
with drift_tau > 0, in all. zero: of the reading, rad/s or, with zero_tau > 0, rad in all."""
PLACE = {name: k for k, name in enumerate(NAMES)}
_F, _LAMBDA, _PHI, _V, _OFFSET, _T, _A, _VS, _LAW, _C, _D, _K, _B, _DRIFT, _DRIFT_TAU, _KICK, _KICK_S = range(17)
_STAGES, _WEIGHTS, _NODES = DOP853.A, DOP853.B, DOP853.C
_STEPS = 64  # of a period
Motion = Mapping[str, float]


def vector(motion: Motion) -> Array:
    """By NAMES; what is not named is 0."""
    return np.array([motion.get(name, 0.0) for name in NAMES])


@njit(cache=True)
def acceleration(t, phi, v, sigma, p):  # type: ignore[no-untyped-def]
    """sigma: direction of the motion, +1 or -1."""
    change = p[_DRIFT] * t
    if p[_DRIFT_TAU] > 0.0:
        change = p[_DRIFT] * (1.0 - math.exp(-t / p[_DRIFT_TAU]))
    w = 2.0 * math.pi * p[_F] * (1.0 + change)
    a = -w * w * (math.sin(phi) + p[_K] * phi**3) + p[_B]
    a -= v * (2.0 * p[_LAMBDA] + p[_C] * sigma * v + p[_D] * phi * phi)
    if p[_T] != 0.0:
        a -= sigma * p[_T] * (1.0 + p[_A] * _fall(sigma * v, p))
    return a


@njit(cache=True)
def _fall(speed, p):  # type: ignore[no-untyped-def]
    if p[_A] == 0.0:
        return 0.0
    if p[_LAW] == 1.0:
        return math.exp(-((speed / p[_VS]) ** 2))
    if p[_LAW] == 2.0:
        return 1.0 / (1.0 + abs(speed) / p[_VS])
    return math.exp(-speed / p[_VS])


@njit(cache=True)
def holds(t, phi, p):  # type: ignore[no-untyped-def]
    """Friction keeps it at rest at this angle."""
    limit = p[_T] * (1.0 + p[_A])
    if limit <= 0.0:
        return False
    rest = acceleration(t, phi, 0.0, 1.0, p) + limit
    return abs(rest) <= limit


@njit(cache=True)
def direction_from_rest(t, phi, p):  # type: ignore[no-untyped-def]
    """Where it goes from a turning point."""
    return math.copysign(1.0, acceleration(t, phi, 0.0, 1.0, p) + p[_T] * (1.0 + p[_A]))


@njit(cache=True)
def _step(t, phi, v, sigma, h, p, a, b, c):  # type: ignore[no-untyped-def]
    kp, kv = np.empty(b.size), np.empty(b.size)
    for s in range(b.size):
        dp = dv = 0.0
        for j in range(s):
            dp += a[s, j] * kp[j]
            dv += a[s, j] * kv[j]
        kp[s] = v + h * dv
        kv[s] = acceleration(t + c[s] * h, phi + h * dp, kp[s], sigma, p)
    dp = dv = 0.0
    for s in range(b.size):
        dp += b[s] * kp[s]
        dv += b[s] * kv[s]
    return phi + h * dp, v + h * dv


@njit(cache=True)
def _between(x, h, y0, v0, a0, y1, v1, a1):  # type: ignore[no-untyped-def]
    """The polynomial of degree 5 through both ends, at the share x of the step."""
    d = y1 - y0 - h * v0 - 0.5 * h * h * a0
    e = h * (v1 - v0) - h * h * a0
    g = h * h * (a1 - a0)
    c3, c4, c5 = 10.0 * d - 4.0 * e + 0.5 * g, -15.0 * d + 7.0 * e - g, 6.0 * d - 3.0 * e + 0.5 * g
    return y0 + x * (h * v0 + x * (0.5 * h * h * a0 + x * (c3 + x * (c4 + x * c5))))


@njit(cache=True)
def _run(times, p, a, b, c):  # type: ignore[no-untyped-def]
    out = np.empty(times.size)
    t, phi, v, k = 0.0, p[_PHI], p[_V], 0
    usual = 1.0 / (_STEPS * p[_F])
    sigma = math.copysign(1.0, v) if v != 0.0 else direction_from_rest(t, phi, p)
    kicked = p[_KICK] == 0.0
    while k < times.size:
        h, turns, kicks = usual, False, False
        if not kicked and t + h >= p[_KICK_S]:
            h, kicks = p[_KICK_S] - t, True
        phi1, v1 = _step(t, phi, v, sigma, h, p, a, b, c)
        if sigma * v1 < 0.0:
            turns, kicks = True, False
            h = h * v / (v - v1) if sigma * v > 0.0 else 0.5 * h
            for _ in range(8):
                phi1, v1 = _step(t, phi, v, sigma, h, p, a, b, c)
                dh = v1 / acceleration(t + h, phi1, v1, sigma, p)
                h -= dh
                if abs(dh) < 1e-15:
                    break
            phi1, v1 = _step(t, phi, v, sigma, h, p, a, b, c)
            v1 = 0.0
        a0 = acceleration(t, phi, v, sigma, p)
        a1 = acceleration(t + h, phi1, v1, sigma, p)
        while k < times.size and times[k] < t + h:
            out[k] = _between((times[k] - t) / h, h, phi, v, a0, phi1, v1, a1)
            k += 1
        t, phi, v = t + h, phi1, v1
        if kicks:
            kicked, v = True, v + p[_KICK]
            sigma = math.copysign(1.0, v)
        elif turns:
            if holds(t, phi, p):
                out[k:] = phi
                break
            sigma = direction_from_rest(t, phi, p)
    return out


def trajectory(times: Array, p: Array) -> Array:
    """The angle at these times, which rise from 0."""
    return np.asarray(_run(times, p, _STAGES, _WEIGHTS, _NODES))


def beside(times: Array, p: Array) -> Any:
    """What the reading holds beside the angle: zero and its drift, and a second mode."""
    zero, tau = p[PLACE["zero"]], p[PLACE["zero_tau"]]
    added = p[_OFFSET] + (zero * (1.0 - np.exp(-times / tau)) if tau > 0.0 else zero * times)
    cos, sin, hz, tau = p[PLACE["mode_cos"] :]
    if tau > 0.0:
        turn = 2.0 * math.pi * hz * times
        added = added + np.exp(-times / tau) * (cos * np.cos(turn) + sin * np.sin(turn))
    return added


def reading(times: Array, p: Array) -> Array:
    """What an ideal encoder shows."""
    return np.asarray(trajectory(times, p) + beside(times, p))
