"""One half cycle: from a turning point to the next, with exact derivatives. Dimensionless time s = w t.

Between two turning points the sign of the velocity is fixed and the equation of motion (eq:Jewel_ODE_norm with
the exact sign) is smooth: an order-8 Runge-Kutta method with a fixed number of steps suffices.

Layout of a node, float64 (fields,) with fields = 4 + 3 columns:
    phi, v, a, jerk (d phi, d2 phi, d3 phi / ds), then per column q: d phi/dq, d v/dq, d a/dq at fixed s.
Column 0 is the amplitude A at the first turning point of all, column k >= 1 the coefficient c[k-1]. Where the torque
depends on u = s - theta, the time since the first sample, a last column is theta.
"""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.numerics.jit import part
from platform_daemon.estimation.physics.torques.dispatch import acceleration, timed_acceleration
from platform_daemon.estimation.thresholds import THRESHOLDS

from .dormand_prince import NODES, STAGE_MATRIX, STAGES, WEIGHTS

LIMITS = THRESHOLDS.physics
STEPS = LIMITS.runge_kutta_steps
_NEWTON_STEPS = LIMITS.turning_point_steps
_CLOSE = LIMITS.turning_point_close
_FOUND = LIMITS.turning_point_found
_TRIALS = LIMITS.duration_trials
_SHORTER = LIMITS.duration_shorter
_LONGER = LIMITS.duration_longer
_SHORTEST_STEP = LIMITS.last_step_shortest
_LONGEST_STEP = LIMITS.last_step_longest

MOVES_UP, MOVES_DOWN, STICKS = 1.0, -1.0, 0.0


@part
def _torque(phi, v, u, columns, sigma, codes, widths, c, grad):  # type: ignore[no-untyped-def]
    """(tau, d tau/d phi, d tau/d v, d tau/d u) of all terms; grad (coefficients + 1,): d tau/d c, then by theta.

    Where there are fewer columns the last coefficients are frozen, and the derivative by theta is in their place.
    """
    f, f_phi, f_v = acceleration(phi, v, sigma, codes, widths, c, grad)
    t, t_phi, t_v, t_u = timed_acceleration(phi, v, u, sigma, codes, widths, c, grad)
    grad[columns - 2 if columns <= c.size else c.size] = -t_u
    return f + t, f_phi + t_phi, f_v + t_v, t_u


@part
def direction_at_rest(phi, u, columns, codes, widths, c, grad):  # type: ignore[no-untyped-def]
    """Where a rotor at rest goes (+1, -1, or 0 where friction of either sign holds it), and its acceleration."""
    likely = -1.0 if phi > 0.0 else 1.0
    pull, _, _, _ = _torque(phi, 0.0, u, columns, likely, codes, widths, c, grad)
    if pull * likely > 0.0:
        return likely, pull
    pull, _, _, _ = _torque(phi, 0.0, u, columns, -likely, codes, widths, c, grad)
    if pull * likely < 0.0:
        return -likely, pull
    return 0.0, 0.0


@part
def _rates(y, u, columns, sigma, codes, widths, c, grad, out):  # type: ignore[no-untyped-def]
    """Right-hand side: state (phi, v) and the variational equations of the columns."""
    a, a_phi, a_v, _ = _torque(y[0], y[1], u, columns, sigma, codes, widths, c, grad)
    out[0] = y[1]
    out[1] = a
    for q in range(columns):
        out[2 + 2 * q] = y[3 + 2 * q]
        out[3 + 2 * q] = a_phi * y[2 + 2 * q] + a_v * y[3 + 2 * q]
        if q > 0:
            out[3 + 2 * q] += grad[q - 1]


@part
def _step(y, u, h, columns, sigma, codes, widths, c, grad, stages, work, out):  # type: ignore[no-untyped-def]
    """One Runge-Kutta step of length h from y at u to out; stages (12, size) and work (size,) are scratch."""
    size = 2 + 2 * columns
    for i in range(STAGES):
        for m in range(size):
            work[m] = y[m]
        for j in range(i):
            weight = h * STAGE_MATRIX[i, j]
            if weight != 0.0:
                for m in range(size):
                    work[m] += weight * stages[j, m]
        _rates(work, u + h * NODES[i], columns, sigma, codes, widths, c, grad, stages[i])
    for m in range(size):
        work[m] = 0.0
    for j in range(STAGES):
        if WEIGHTS[j] != 0.0:
            for m in range(size):
                work[m] += WEIGHTS[j] * stages[j, m]
    for m in range(size):
        out[m] = y[m] + h * work[m]


@part
def _write_node(y, u, columns, sigma, codes, widths, c, grad, node):  # type: ignore[no-untyped-def]
    """Fill a node (see module docstring) from the state y at u."""
    a, a_phi, a_v, a_u = _torque(y[0], y[1], u, columns, sigma, codes, widths, c, grad)
    node[0] = y[0]
    node[1] = y[1]
    node[2] = a
    node[3] = a_phi * y[1] + a_v * a + a_u
    for q in range(columns):
        node[4 + 3 * q] = y[2 + 2 * q]
        node[5 + 3 * q] = y[3 + 2 * q]
        node[6 + 3 * q] = a_phi * y[2 + 2 * q] + a_v * y[3 + 2 * q]
        if q > 0:
            node[6 + 3 * q] += grad[q - 1]


@part
def _last_step(y, u, guess, columns, sigma, codes, widths, c, grad, stages, work, out):  # type: ignore[no-untyped-def]
    """Step from y to the turning point v = 0, by Newton's method on its length, which is returned; -1 if none."""
    length = guess
    for _ in range(_NEWTON_STEPS):
        _step(y, u, length, columns, sigma, codes, widths, c, grad, stages, work, out)
        a, _, _, _ = _torque(out[0], out[1], u + length, columns, sigma, codes, widths, c, grad)
        if not sigma * a < 0.0:
            return -1.0
        correction = -out[1] / a
        if abs(correction) <= _CLOSE:
            return length
        length += correction
    return length if abs(correction) < _FOUND else -1.0


@part
def integrate_half_cycle(begin, u, sigma, columns, codes, widths, c, guess, nodes):  # type: ignore[no-untyped-def]
    """Integrate from the turning point `begin`, (2 + 2 columns,) as in _rates, at u in direction sigma.

    nodes: (STEPS + 1, fields) out. guess: expected duration. Steps 1 .. STEPS-1 have length guess/STEPS, the last one
    ends at the turning point. Returns (h, duration), or (0, -1) if no turning point was found.
    """
    size = begin.size
    y = np.empty(size)
    grad = np.zeros(c.size + 1)
    stages = np.empty((STAGES, size))
    work = np.empty(size)
    out = np.empty(size)
    for _ in range(_TRIALS):
        h = guess / STEPS
        for m in range(size):
            y[m] = begin[m]
        _write_node(y, u, columns, sigma, codes, widths, c, grad, nodes[0])
        done = 0
        while done < STEPS - 1:
            _step(y, u + done * h, h, columns, sigma, codes, widths, c, grad, stages, work, out)
            if not sigma * out[1] > 0.0:
                break
            for m in range(size):
                y[m] = out[m]
            done += 1
            _write_node(y, u + done * h, columns, sigma, codes, widths, c, grad, nodes[done])
        if done < STEPS - 1:
            guess *= _SHORTER
            continue
        at = u + done * h
        last = _last_step(y, at, h, columns, sigma, codes, widths, c, grad, stages, work, out)
        if last < 0.0 or last > _LONGEST_STEP * h:
            guess *= _LONGER
            continue
        if last < _SHORTEST_STEP * h:
            guess = (STEPS - 1) * h + last
            continue
        _write_node(out, at + last, columns, sigma, codes, widths, c, grad, nodes[STEPS])
        return h, (STEPS - 1) * h + last
    return 0.0, -1.0


@part
def integrate_arrival(end, u, sigma, length, columns, codes, widths, c, nodes):  # type: ignore[no-untyped-def]
    """The last `length` of the half cycle that ends at the turning point `end` at u, going back from there.

    sigma: direction in which it arrives. nodes: (STEPS + 1, fields) out, in the order of time. Returns the step,
    or 0 if it did not come that way for so long.
    """
    y = end.copy()
    grad = np.zeros(c.size + 1)
    stages = np.empty((STAGES, end.size))
    work = np.empty(end.size)
    out = np.empty(end.size)
    h = length / STEPS
    _write_node(y, u, columns, sigma, codes, widths, c, grad, nodes[STEPS])
    for k in range(STEPS):
        _step(y, u - k * h, -h, columns, sigma, codes, widths, c, grad, stages, work, out)
        for m in range(end.size):
            y[m] = out[m]
        if not sigma * y[1] > 0.0:
            return 0.0
        _write_node(y, u - (k + 1) * h, columns, sigma, codes, widths, c, grad, nodes[STEPS - 1 - k])
    return h
