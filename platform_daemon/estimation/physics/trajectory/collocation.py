"""One half cycle as a whole: the acceleration at Chebyshev nodes by Newton's method, with exact derivatives.

Written in the mirrored frame of its direction (`side`, +1 or -1): every half cycle begins at angle -size, at rest,
and moves up. With a(x) the acceleration as a polynomial on the unit interval and D the duration,
    phi = -size + D^2 (integral twice of a),   v = D (integral of a),   a = tau(phi, v)  at the nodes,  v(end) = 0.
The sensitivities solve the same linear system, so they are exact derivatives of what is computed.
"""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.numerics.jit import fast_part
from platform_daemon.estimation.numerics.linear_systems import factorise, substitute
from platform_daemon.estimation.physics.torques.dispatch import acceleration
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.physics
_MOST_STEPS = LIMITS.collocation_steps
_MOST_STRETCH = LIMITS.collocation_stretch_share
_WIDEST = LIMITS.collocation_widest_rad


@fast_part
def _integrate(once, twice, a, single, double):  # type: ignore[no-untyped-def]
    """Integrals single, double (m + 1,) of a (m,), once and twice, at all nodes and at the end."""
    for i in range(single.size):
        s = d = 0.0
        for k in range(a.size):
            s += once[i, k] * a[k]
            d += twice[i, k] * a[k]
        single[i] = s
        double[i] = d


@fast_part
def _linearise(  # type: ignore[no-untyped-def]
    size, side, duration, codes, widths, c, once, twice, a, single, double, grad, phi, v, matrix, residual, by_duration
):
    """What Newton's method solves for the acceleration a (m,): residual (m,) = tau - a, minus its
    derivatives by a, matrix (m, m), and those by the duration, by_duration (m,); phi, v (m,) are those of a.
    """
    square = duration * duration
    for i in range(a.size):
        phi[i] = square * double[i] - size
        v[i] = duration * single[i]
        tau, tau_phi, tau_v = acceleration(side * phi[i], side * v[i], side, codes, widths, c, grad)
        residual[i] = side * tau - a[i]
        by_duration[i] = tau_phi * 2.0 * duration * double[i] + tau_v * single[i]
        for j in range(a.size):
            matrix[i, j] = -square * tau_phi * twice[i, j] - duration * tau_v * once[i, j]
        matrix[i, i] += 1.0


@fast_part
def solve_half_cycle(  # type: ignore[no-untyped-def]
    size, side, duration, settled, columns, codes, widths, c, once, twice, a, phi, v, slopes, end
):
    """Solve the half cycle from -size (mirrored frame), given guesses of its `duration` and acceleration a (m,).

    settled: size of the last Newton step, relative; the error after it is about its square.
    Out: a, phi, v (m,) at the nodes; slopes (columns, 3, m) d a, d phi, d v by size and by c at fixed time; end
    (2 + 2 columns,): duration, next size, d next/d q, d duration/d q. Returns False if there is no turning point.
    """
    m = a.size
    matrix = np.empty((m, m))
    order = np.empty(m, dtype=np.int64)
    forcing = np.empty((columns, m))
    grad = np.zeros(c.size + 1)
    residual = np.empty(m)
    by_duration = np.empty(m)
    single = np.empty(m + 1)
    double = np.empty(m + 1)
    done = False
    for _ in range(_MOST_STEPS):
        _integrate(once, twice, a, single, double)
        _linearise(
            size, side, duration, codes, widths, c, once, twice, a, single, double, grad, phi, v, matrix, residual,
            by_duration,
        )  # fmt: skip
        if not factorise(matrix, order):
            return False
        substitute(matrix, order, residual)
        substitute(matrix, order, by_duration)
        excess = single[m]
        slope = 0.0
        for i in range(m):
            excess += once[m, i] * residual[i]
            slope += once[m, i] * by_duration[i]
        stretch = -excess / slope
        if not abs(stretch) < duration:
            return False
        largest = abs(stretch) / duration
        for i in range(m):
            change = residual[i] + stretch * by_duration[i]
            a[i] += change
            largest = max(largest, abs(change) / size)
        if abs(stretch) > _MOST_STRETCH * duration:
            stretch = _MOST_STRETCH * duration if stretch > 0.0 else -_MOST_STRETCH * duration
        duration += stretch
        done = largest < settled
        if done:
            break
    if not done:
        return False
    _finish(
        size, side, duration, columns, codes, widths, c, once, twice, a, phi, v, slopes, end, matrix, order, forcing,
        single, double,
    )  # fmt: skip
    return end[1] < _WIDEST and duration > 0.0


@fast_part
def _finish(  # type: ignore[no-untyped-def]
    size, side, duration, columns, codes, widths, c, once, twice, a, phi, v, slopes, end, matrix, order, forcing,
    single, double,
):  # fmt: skip
    """Final values, sensitivities and end values from a settled solution.

    The factors are those of the last Newton step; one refinement with the final derivatives makes the sensitivities
    exact. It matters: their errors add up over a thousand half cycles.
    """
    m = a.size
    square = duration * duration
    by_phi = np.empty(m)
    by_v = np.empty(m)
    rest = np.empty(m)
    grad = np.zeros(c.size + 1)
    _integrate(once, twice, a, single, double)
    for i in range(m):
        phi[i] = square * double[i] - size
        v[i] = duration * single[i]
        _, by_phi[i], by_v[i] = acceleration(side * phi[i], side * v[i], side, codes, widths, c, grad)
        for q in range(1, columns):
            forcing[q, i] = side * grad[q - 1]
    end[0] = duration
    end[1] = square * double[m] - size
    last, _, _ = acceleration(side * end[1], 0.0, side, codes, widths, c, grad)
    for q in range(columns):
        moved = -1.0 if q == 0 else 0.0
        d_a = slopes[q, 0]
        for i in range(m):
            own = 0.0 if q == 0 else forcing[q, i]
            rest[i] = own + by_phi[i] * moved
            d_a[i] = rest[i]
        substitute(matrix, order, d_a)
        _integrate(once, twice, d_a, single, double)
        for i in range(m):
            rest[i] += square * by_phi[i] * double[i] + duration * by_v[i] * single[i] - d_a[i]
        substitute(matrix, order, rest)
        for i in range(m):
            d_a[i] += rest[i]
        _integrate(once, twice, d_a, single, double)
        for i in range(m):
            slopes[q, 1, i] = square * double[i] + moved
            slopes[q, 2, i] = duration * single[i]
        end[2 + q] = square * double[m] + moved
        end[2 + columns + q] = -duration * single[m] / (side * last)
