"""A ring-down as a chain of half cycles, each integrated: the direct path, for any torque, with its derivatives.

At a turning point the angle and its derivatives continue. The acceleration jumps from a to a' where friction changes
sides, and with it the derivatives of the velocity: the turning point moves by ds = -dv/a, after it dv' = -a' ds.
"""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.jit import kernel
from platform_daemon.estimation.thresholds import THRESHOLDS

from .runge_kutta import STEPS, direction_at_rest, integrate_arrival, integrate_half_cycle

LIMITS = THRESHOLDS.physics
_WIDEST = LIMITS.direct_widest_rad

# Columns of `heads`, float64 (n_half, HEAD): where each half cycle begins.
HEAD_START, HEAD_STEP, HEAD_DURATION, HEAD = 0, 1, 2, 3
STATUS_OK, STATUS_STUCK, STATUS_LOST = 0, 1, 2


@kernel
def trace_half_cycles(amplitude, theta, s_end, columns, codes, widths, c, heads, nodes):  # type: ignore[no-untyped-def]
    """Chain half cycles from the turning point (amplitude, s = 0) until s_end or until the rotor sticks.

    theta: s at t = 0; if negative, the first row is what remains of the half cycle that arrives at s = 0.
    heads: (n_max, HEAD) out: start s, step h, duration. nodes: (n_max, STEPS + 1, fields) out.
    Returns (count, status): STATUS_OK, STATUS_STUCK (at rest from the last row's start on: that row has duration
    0 and one node), STATUS_LOST (no turning point; count rows are valid).
    """
    grad = np.zeros(c.size + 1)
    begin = np.zeros(2 + 2 * columns)
    begin[0] = amplitude
    begin[2] = 1.0
    start = 0.0
    carry = 0.0  # compensated sum: the start times are what the phase accuracy of 1e-9 rests on
    guess = math.pi
    before = 0.0
    arrives = 0
    if theta < 0.0:
        leaves, _ = direction_at_rest(amplitude, -theta, columns, codes, widths, c, grad)
        sigma = -leaves if leaves != 0.0 else math.copysign(1.0, amplitude)
        heads[0, HEAD_START] = theta
        heads[0, HEAD_DURATION] = -theta
        heads[0, HEAD_STEP] = integrate_arrival(begin, -theta, sigma, -theta, columns, codes, widths, c, nodes[0])
        if heads[0, HEAD_STEP] == 0.0:
            return 0, STATUS_LOST
        arrives = 1
    for count in range(arrives, heads.shape[0]):
        heads[count, HEAD_START] = start
        if start > s_end:
            return count, STATUS_OK
        sigma, pull = direction_at_rest(begin[0], start - theta, columns, codes, widths, c, grad)
        for q in range(columns):
            begin[3 + 2 * q] *= pull / before if before != 0.0 else 0.0
        if sigma == 0.0:
            heads[count, HEAD_STEP] = 0.0
            heads[count, HEAD_DURATION] = 0.0
            nodes[count, 0, 0] = begin[0]
            for q in range(columns):
                nodes[count, 0, 4 + 3 * q] = begin[2 + 2 * q]
            return count + 1, STATUS_STUCK
        if abs(begin[0]) > _WIDEST:
            return count, STATUS_LOST
        h, duration = integrate_half_cycle(begin, start - theta, sigma, columns, codes, widths, c, guess, nodes[count])
        if duration < 0.0:
            return count, STATUS_LOST
        heads[count, HEAD_STEP] = h
        heads[count, HEAD_DURATION] = duration
        end = nodes[count, STEPS]
        begin[0] = end[0]
        before = end[2]
        for q in range(columns):
            begin[2 + 2 * q] = end[4 + 3 * q]
            begin[3 + 2 * q] = end[5 + 3 * q]
        guess = duration
        term = duration - carry
        total = start + term
        carry = (total - start) - term
        start = total
    return heads.shape[0], STATUS_LOST
