"""The receive chain's frequency response, applied exactly to the rotor's signal.

A product of first-order poles is a sum of single poles (partial fractions), and a polynomial goes through one pole in
closed form.  The rotor's EMF is a polynomial in every piece of its motion, so the output is a polynomial plus one dying
exponential, continued from piece to piece: for a pole tau the output y solves tau y' + y = p(t) with the input
polynomial p, so y = q(t) + (y_0 - q(t_0)) exp(-(t - t_0)/tau) with the polynomial q that solves the same equation.  A
pole that is slow against the piece makes the coefficients of q cancel, so there y is summed as a Taylor series.  A
sampling delay is applied by evaluating at the delayed instants.  There is no digital filter and no interpolation
between samples; the only errors are those of the pieces.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp

import numpy as np
from numpy.typing import NDArray

from sim_backend.options import ChainOptions
from sim_backend.rotor.kernel import kernel
from sim_backend.rotor.pieces import NODES

TAYLOR = 40


@dataclass(frozen=True)
class Partial:
    """One term weight / (1 + i 2 pi f tau_s) of a channel's response; tau_s = 0: flat."""

    weight: float
    tau_s: float


def partials(poles_hz: tuple[float, ...]) -> list[Partial]:
    """The product of 1 / (1 + i f / pole) as a sum of single poles."""
    tau = [1 / (2 * np.pi * f) for f in poles_hz]
    if not tau:
        return [Partial(1.0, 0.0)]
    return [
        Partial(float(np.prod([t / (t - other) for j, other in enumerate(tau) if j != i])), t)
        for i, t in enumerate(tau)
    ]


@kernel
def _horner(c, n, x):  # type: ignore[no-untyped-def]
    total = 0.0
    for k in range(n - 1, -1, -1):
        total = total * x + c[k]
    return total


@kernel
def _slow_pole(p, kappa, y, out):  # type: ignore[no-untyped-def]
    """Powers of s = x + 1 of the solution of kappa dy/dx = p - y with y at s = 0, by its Taylor series; kappa > 0.5."""
    shifted = p.copy()
    for i in range(NODES - 1):
        for k in range(NODES - 2, i - 1, -1):
            shifted[k] -= shifted[k + 1]
    out[0] = y
    for k in range(TAYLOR - 1):
        source = shifted[k] if k < NODES else 0.0
        out[k + 1] = (source - out[k]) / (kappa * (k + 1))


@kernel
def add_filtered(pieces, connected, times, per_g, weight, tau, out):  # type: ignore[no-untyped-def]
    """Add weight times the response of one pole to the sum of per_g g at rising `times` (n,) onto out (n,).

    per_g: (2,) for g_u, g_v, or (3,) with g_w for pieces that have it; connected: (pieces,) bool, False: the input is
    zero.  Nothing is added at times before the first piece.
    """
    p, q, series = np.zeros(NODES), np.zeros(NODES), np.zeros(TAYLOR)
    y = 0.0
    i = 0
    while pieces.shape[0] > 0 and i < times.size and times[i] < pieces[0, 0]:
        i += 1
    for j in range(pieces.shape[0]):
        start = pieces[j, 0]
        h = pieces[j, 1]
        for k in range(NODES):
            total = 0.0
            if connected[j]:
                for axis in range(per_g.size):
                    total += per_g[axis] * pieces[j, 4 + (1 + axis) * NODES + k]
            p[k] = total
        kappa = 2.0 * tau / h
        slow = kappa > 0.5
        offset = 0.0
        if slow:
            _slow_pole(p, kappa, y, series)
        else:
            q[NODES - 1] = p[NODES - 1]
            for k in range(NODES - 2, -1, -1):
                q[k] = p[k] - kappa * (k + 1) * q[k + 1]
            offset = y - _horner(q, NODES, -1.0)
        last = j == pieces.shape[0] - 1
        while i < times.size and (times[i] < start + h or last):
            x = 2.0 * (times[i] - start) / h - 1.0
            if slow:
                out[i] += weight * _horner(series, TAYLOR, x + 1.0)
            else:
                value = _horner(q, NODES, x)
                if kappa > 0.0:
                    value += offset * exp(-(x + 1.0) / kappa)
                out[i] += weight * value
            i += 1
        if slow:
            y = _horner(series, TAYLOR, 2.0)
        else:
            y = _horner(q, NODES, 1.0)
            if kappa > 0.0:
                y += offset * exp(-2.0 / kappa)


def receive_v(
    pieces: NDArray[np.float64],
    connected: NDArray[np.bool_],
    times_s: NDArray[np.float64],
    per_g_v: NDArray[np.float64],
    chain: ChainOptions,
) -> NDArray[np.float64]:
    """Noise-free signal of every channel at the ADC: (channel, n) float64, V.

    pieces (k, PIECE_SLOTS), connected (k,) bool; times_s (n,) rising; per_g_v (channel, 2 or 3): volts at the ADC per
    g_u, g_v and, of a rigid body, g_w (rad/s), that is -m_r P [e_u e_v e_w] (eq:u(t,p,R), eq:projection).
    """
    out = np.zeros((len(chain.poles_hz), times_s.size))
    for row, weights, poles, delay_s in zip(
        out, np.ascontiguousarray(per_g_v), chain.poles_hz, chain.residual_delay_s, strict=True
    ):
        for part in partials(poles):
            add_filtered(pieces, connected, times_s - delay_s, weights, part.weight, part.tau_s, row)
    return out
