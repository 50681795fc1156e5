"""The traced ring-down at sample times: basis functions of the observation, and their moments with the data.

For one observable pair (f1, f2) and Q = 2 + columns dynamic parameters (order: s at fixed trajectory i.e. the phase
theta, then w t inside it i.e. d/dw, then A and c) the basis is, float64 (n_basis,) per sample,

    f1, f2, (d f1/d p, d f2/d p) for p = theta, w, A, c[0], c[1] ..., 1

DIPOLE: f1 = v cos(phi), f2 = -v sin(phi), the v and u components of eq:projection over m_r w.
STATE:  f1 = phi, f2 = v, for start states and for an observed angle.
"""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.jit import kernel, part

from .direct_chain import HEAD_DURATION, HEAD_START, HEAD_STEP
from .runge_kutta import STEPS

DIPOLE, STATE = 0, 1


@part
def _angle_polynomial(left, right, h, out):  # type: ignore[no-untyped-def]
    """Degree-7 Hermite polynomial of phi on a step (x in 0..1), out (8,): phi, v, a, jerk match at both ends."""
    f0, f1, f2, f3 = left[0], h * left[1], h * h * left[2] / 2.0, h * h * h * left[3] / 6.0
    # What the cubic Taylor part misses at the right end, as derivatives with respect to x.
    e0 = right[0] - (f0 + f1 + f2 + f3)
    e1 = h * right[1] - (f1 + 2.0 * f2 + 3.0 * f3)
    e2 = h * h * right[2] - (2.0 * f2 + 6.0 * f3)
    e3 = h * h * h * right[3] - 6.0 * f3
    out[0], out[1], out[2], out[3] = f0, f1, f2, f3
    out[4] = 35.0 * e0 - 15.0 * e1 + 2.5 * e2 - e3 / 6.0
    out[5] = -84.0 * e0 + 39.0 * e1 - 7.0 * e2 + 0.5 * e3
    out[6] = 70.0 * e0 - 34.0 * e1 + 6.5 * e2 - 0.5 * e3
    out[7] = -20.0 * e0 + 10.0 * e1 - 2.0 * e2 + e3 / 6.0


@part
def _sensitivity_polynomials(left, right, h, columns, out):  # type: ignore[no-untyped-def]
    """Degree-5 Hermite polynomials of d phi/dq on a step for all columns q; out (columns, 6)."""
    for q in range(columns):
        f0 = left[4 + 3 * q]
        f1 = h * left[5 + 3 * q]
        f2 = 0.5 * h * h * left[6 + 3 * q]
        e0 = right[4 + 3 * q] - (f0 + f1 + f2)
        e1 = h * right[5 + 3 * q] - (f1 + 2.0 * f2)
        e2 = h * h * right[6 + 3 * q] - 2.0 * f2
        out[q, 0], out[q, 1], out[q, 2] = f0, f1, f2
        out[q, 3] = 10.0 * e0 - 4.0 * e1 + 0.5 * e2
        out[q, 4] = -15.0 * e0 + 7.0 * e1 - e2
        out[q, 5] = 6.0 * e0 - 3.0 * e1 + 0.5 * e2


@part
def _write_basis(phi, v, a, d_phi, d_v, time, observable, columns, out, i):  # type: ignore[no-untyped-def]
    """Write one sample's basis into out[:, i] from the state and its derivatives (columns,) at fixed t and w."""
    if observable == DIPOLE:
        sine = math.sin(phi)
        cosine = math.cos(phi)
        f1 = v * cosine
        f2 = -v * sine
        slope1 = a * cosine - v * v * sine
        slope2 = -a * sine - v * v * cosine
        x1_phi, x1_v = -v * sine, cosine
        x2_phi, x2_v = -v * cosine, -sine
    else:
        f1, f2, slope1, slope2 = phi, v, v, a
        x1_phi, x1_v, x2_phi, x2_v = 1.0, 0.0, 0.0, 1.0
    out[0, i] = f1
    out[1, i] = f2
    out[2, i] = slope1
    out[3, i] = slope2
    out[4, i] = slope1 * time
    out[5, i] = slope2 * time
    for p in range(columns):
        out[6 + 2 * p, i] = x1_phi * d_phi[p] + x1_v * d_v[p]
        out[7 + 2 * p, i] = x2_phi * d_phi[p] + x2_v * d_v[p]
    out[6 + 2 * columns, i] = 1.0


@kernel
def fill_basis(  # type: ignore[no-untyped-def]
    first, last, dt, w, theta, columns, count, heads, nodes, observable, row, out
):
    """Basis at the samples first .. last-1 (t = i dt, s = w t + theta) into out (n_basis, last - first).

    row: half cycle to begin the search at. Returns the half cycle of the last sample.
    """
    angle = np.empty(8)
    sens = np.empty((columns, 6))
    d_phi = np.zeros(columns)
    d_v = np.zeros(columns)
    current_row = -1
    current_step = -1
    h = 1.0
    for i in range(first, last):
        time = i * dt
        s = w * time + theta
        while row + 1 < count and s >= heads[row + 1, HEAD_START]:
            row += 1
        head = heads[row]
        if head[HEAD_DURATION] == 0.0:
            # Stuck: the rotor rests, and only its angle still depends on the parameters.
            for p in range(columns):
                d_phi[p] = nodes[row, 0, 4 + 3 * p]
                d_v[p] = 0.0
            _write_basis(nodes[row, 0, 0], 0.0, 0.0, d_phi, d_v, time, observable, columns, out, i - first)
            continue
        local = s - head[HEAD_START]
        step = min(max(int(local / head[HEAD_STEP]), 0), STEPS - 1)
        if row != current_row or step != current_step:
            h = head[HEAD_STEP]
            if step == STEPS - 1:
                h = head[HEAD_DURATION] - (STEPS - 1) * head[HEAD_STEP]
            _angle_polynomial(nodes[row, step], nodes[row, step + 1], h, angle)
            _sensitivity_polynomials(nodes[row, step], nodes[row, step + 1], h, columns, sens)
            current_row = row
            current_step = step
        x = (local - step * head[HEAD_STEP]) / h
        phi = angle[7]
        v = 0.0
        a = 0.0
        for k in range(6, -1, -1):
            a = a * x + v
            v = v * x + phi
            phi = phi * x + angle[k]
        v /= h
        a *= 2.0 / (h * h)
        for p in range(columns):
            value = sens[p, 5]
            slope = 0.0
            for k in range(4, -1, -1):
                slope = slope * x + value
                value = value * x + sens[p, k]
            d_phi[p] = value
            d_v[p] = slope / h
        _write_basis(phi, v, a, d_phi, d_v, time, observable, columns, out, i - first)
    return row
