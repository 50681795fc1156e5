"""A ring-down as a chain of half swings: A -> next amplitude, S -> S + duration, derivatives carried along.

The jump of the sensitivities at a turning point needs no formula of its own: with E(A, c) the angle at the end and
D(A, c) the duration of a half swing, dS/dq and dA/dq follow from the chain rule, and inside a half swing
    dphi/dq = W_A dA/dq + W_q - v dS/dq,        W(s - S; A, c) the half swing itself.
"""

from __future__ import annotations

import math

import numpy as np

from .half_swing import STEPS, direction_at_rest, integrate_half_swing
from .jit import kernel

# Columns of `heads`, float64 (n_half, HEAD + 2 columns): where each half swing begins.
HEAD_START, HEAD_STEP, HEAD_DURATION, HEAD_AMPLITUDE, HEAD = 0, 1, 2, 3, 4
STATUS_OK, STATUS_STUCK, STATUS_LOST = 0, 1, 2
_WIDEST = 3.0  # rad; close to the inverted position a half swing takes forever


@kernel
def _carry_slopes(end, columns, slope_a, slope_s):  # type: ignore[no-untyped-def]
    """Chain rule over one half swing that ends at node `end`: update dA/dq and dS/dq (columns,) in place."""
    for q in range(columns):
        d_duration = -end[5 + 3 * q] / end[2]
        if q == 0:
            for p in range(columns):
                slope_s[p] += d_duration * slope_a[p]
        else:
            slope_s[q] += d_duration
    for p in range(columns):
        slope_a[p] *= end[4]
    for q in range(1, columns):
        slope_a[q] += end[4 + 3 * q]


@kernel
def trace_half_swings(amplitude, s_end, columns, codes, widths, c, heads, nodes):  # type: ignore[no-untyped-def]
    """Chain half swings from the turning point (amplitude, s = 0) until s_end or until the rotor sticks.

    heads: (n_max, HEAD + 2 columns) out: start S, step h, duration, amplitude, dA/dq (columns), dS/dq (columns).
    nodes: (n_max, STEPS + 1, fields) out.
    Returns (count, status): STATUS_OK, STATUS_STUCK (at rest from the last row's start on: that row has duration
    0), STATUS_LOST (no turning point; count rows are valid).
    """
    grad = np.zeros(c.size + 1)
    slope_a = np.zeros(columns)
    slope_s = np.zeros(columns)
    slope_a[0] = 1.0
    start = 0.0
    carry = 0.0  # compensated sum: the start times are what the phase accuracy of 1e-9 rests on
    guess = math.pi
    count = 0
    while count < heads.shape[0]:
        head = heads[count]
        head[HEAD_START] = start
        head[HEAD_AMPLITUDE] = amplitude
        for q in range(columns):
            head[HEAD + q] = slope_a[q]
            head[HEAD + columns + q] = slope_s[q]
        if start > s_end:
            return count, STATUS_OK
        sigma = direction_at_rest(amplitude, codes, widths, c, grad)
        if sigma == 0.0:
            head[HEAD_STEP] = 0.0
            head[HEAD_DURATION] = 0.0
            return count + 1, STATUS_STUCK
        if abs(amplitude) > _WIDEST:
            return count, STATUS_LOST
        h, duration = integrate_half_swing(amplitude, sigma, columns, codes, widths, c, guess, nodes[count])
        if duration < 0.0:
            return count, STATUS_LOST
        head[HEAD_STEP] = h
        head[HEAD_DURATION] = duration
        end = nodes[count, STEPS]
        _carry_slopes(end, columns, slope_a, slope_s)
        amplitude = end[0]
        guess = duration
        term = duration - carry
        total = start + term
        carry = (total - start) - term
        start = total
        count += 1
    return count, STATUS_LOST
