"""One half swing: from a turning point to the next, with exact derivatives. Dimensionless time s = w t.

Between two turning points the sign of the velocity is fixed and the equation of motion (eq:Jewel_ODE_norm with
the exact sign) is smooth: an order-8 Runge-Kutta method with a fixed number of steps suffices.

Layout of a node, float64 (fields,) with fields = 4 + 3 columns:
    phi, v, a, jerk (d phi, d2 phi, d3 phi / ds), then per column q: d phi/dq, d v/dq, d a/dq at fixed s.
Column 0 is the amplitude A at the start of the half swing, column k >= 1 the coefficient c[k-1].
"""

from __future__ import annotations

import numpy as np

from .jit import kernel
from .tableau import STAGE_MATRIX, STAGES, WEIGHTS
from .terms.dispatch import acceleration

STEPS = 32  # per half swing: the trajectory error stays below 1e-9 of the signal up to 75 degrees
MOVES_UP, MOVES_DOWN, STICKS = 1.0, -1.0, 0.0


@kernel
def direction_at_rest(phi, codes, widths, c, grad):  # type: ignore[no-untyped-def]
    """Where a rotor at rest at `phi` goes: +1, -1, or 0 where friction of either sign can hold it (it sticks)."""
    likely = -1.0 if phi > 0.0 else 1.0
    pull, _, _ = acceleration(phi, 0.0, likely, codes, widths, c, grad)
    if pull * likely > 0.0:
        return likely
    pull, _, _ = acceleration(phi, 0.0, -likely, codes, widths, c, grad)
    if pull * likely < 0.0:
        return -likely
    return 0.0


@kernel
def _rates(y, columns, sigma, codes, widths, c, grad, out):  # type: ignore[no-untyped-def]
    """Right-hand side: state (phi, v) and the variational equations of the first `columns` columns."""
    a, a_phi, a_v = acceleration(y[0], y[1], sigma, codes, widths, c, grad)
    out[0] = y[1]
    out[1] = a
    for q in range(columns):
        out[2 + 2 * q] = y[3 + 2 * q]
        out[3 + 2 * q] = a_phi * y[2 + 2 * q] + a_v * y[3 + 2 * q]
        if q > 0:
            out[3 + 2 * q] += grad[q - 1]


@kernel
def _step(y, h, columns, sigma, codes, widths, c, grad, stages, work, out):  # type: ignore[no-untyped-def]
    """One Runge-Kutta step of length h from y to out; stages (12, size) and work (size,) are scratch."""
    size = 2 + 2 * columns
    for i in range(STAGES):
        for m in range(size):
            work[m] = y[m]
        for j in range(i):
            weight = h * STAGE_MATRIX[i, j]
            if weight != 0.0:
                for m in range(size):
                    work[m] += weight * stages[j, m]
        _rates(work, columns, sigma, codes, widths, c, grad, stages[i])
    for m in range(size):
        work[m] = 0.0
    for j in range(STAGES):
        if WEIGHTS[j] != 0.0:
            for m in range(size):
                work[m] += WEIGHTS[j] * stages[j, m]
    for m in range(size):
        out[m] = y[m] + h * work[m]


@kernel
def _write_node(y, columns, sigma, codes, widths, c, grad, node):  # type: ignore[no-untyped-def]
    """Fill a node (see module docstring) from the state y."""
    a, a_phi, a_v = acceleration(y[0], y[1], sigma, codes, widths, c, grad)
    node[0] = y[0]
    node[1] = y[1]
    node[2] = a
    node[3] = a_phi * y[1] + a_v * a
    for q in range(columns):
        node[4 + 3 * q] = y[2 + 2 * q]
        node[5 + 3 * q] = y[3 + 2 * q]
        node[6 + 3 * q] = a_phi * y[2 + 2 * q] + a_v * y[3 + 2 * q]
        if q > 0:
            node[6 + 3 * q] += grad[q - 1]


@kernel
def _last_step(y, guess, columns, sigma, codes, widths, c, grad, stages, work, out):  # type: ignore[no-untyped-def]
    """Step from y to the turning point v = 0, by Newton's method on its length, which is returned; -1 if none."""
    length = guess
    for _ in range(12):
        _step(y, length, columns, sigma, codes, widths, c, grad, stages, work, out)
        a, _, _ = acceleration(out[0], out[1], sigma, codes, widths, c, grad)
        if not sigma * a < 0.0:
            return -1.0
        correction = -out[1] / a
        if abs(correction) <= 1e-15:
            return length
        length += correction
    return length if abs(correction) < 1e-12 else -1.0


@kernel
def integrate_half_swing(amplitude, sigma, columns, codes, widths, c, guess, nodes):  # type: ignore[no-untyped-def]
    """Integrate from (amplitude, 0) in direction sigma; fill nodes (STEPS + 1, fields).

    guess: expected duration. Steps 1 .. STEPS-1 have length guess/STEPS, the last one ends at the turning point.
    Returns (h, duration), or (0, -1) if no turning point was found.
    """
    size = 2 + 2 * columns
    y = np.zeros(size)
    grad = np.zeros(c.size + 1)
    stages = np.empty((STAGES, size))
    work = np.empty(size)
    out = np.empty(size)
    for _ in range(60):
        h = guess / STEPS
        for m in range(size):
            y[m] = 0.0
        y[0] = amplitude
        if columns > 0:
            y[2] = 1.0
        _write_node(y, columns, sigma, codes, widths, c, grad, nodes[0])
        done = 0
        while done < STEPS - 1:
            _step(y, h, columns, sigma, codes, widths, c, grad, stages, work, out)
            if not sigma * out[1] > 0.0:
                break
            for m in range(size):
                y[m] = out[m]
            done += 1
            _write_node(y, columns, sigma, codes, widths, c, grad, nodes[done])
        if done < STEPS - 1:
            guess *= 0.9
            continue
        last = _last_step(y, h, columns, sigma, codes, widths, c, grad, stages, work, out)
        if last < 0.0 or last > 2.0 * h:
            guess *= 1.08
            continue
        if last < 0.3 * h:
            guess = (STEPS - 1) * h + last
            continue
        _write_node(out, columns, sigma, codes, widths, c, grad, nodes[STEPS])
        return h, (STEPS - 1) * h + last
    return 0.0, -1.0
