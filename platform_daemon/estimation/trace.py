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
_BAND_NODES = 14
_BAND_RATIO = 2.5
_WIDEST = 3.0  # rad; close to the inverted position a half swing takes forever


@kernel
def _build_band(low, high, sigma, columns, codes, widths, c, guess, grid, table, durations):  # type: ignore[no-untyped-def]
    """Half swings at the Chebyshev amplitudes of [low, high]: grid (NA,), table (NA, STEPS + 1, fields).

    The nodes of all of them stand at the same fractions of their own duration, so they are smooth in A.
    durations (NA,) is filled too. Returns False if a half swing found no end.
    """
    count = grid.size
    for k in range(count):
        x = math.cos(math.pi * (2 * k + 1) / (2 * count))
        grid[k] = 0.5 * (low + high) + 0.5 * (high - low) * x
        duration = guess
        for _ in range(4):
            before = duration
            _, duration = integrate_half_swing(-sigma * grid[k], sigma, columns, codes, widths, c, before, table[k])
            if duration < 0.0:
                return False
            if abs(duration - before) < 1e-14 * duration:
                break
        durations[k] = duration
        guess = duration
    return True


@kernel
def _interpolate(amplitude, grid, table, durations, weights, nodes):  # type: ignore[no-untyped-def]
    """Barycentric interpolation in the amplitude of all node values; returns (h, duration)."""
    count = grid.size
    total = 0.0
    exact = -1
    for k in range(count):
        distance = amplitude - grid[k]
        if distance == 0.0:
            exact = k
            break
        sign = 1.0 if k % 2 == 0 else -1.0
        weights[k] = sign * math.sin(math.pi * (2 * k + 1) / (2 * count)) / distance
        total += weights[k]
    if exact >= 0:
        for k in range(count):
            weights[k] = 0.0
        weights[exact] = 1.0
        total = 1.0
    flat = nodes.reshape(nodes.size)
    flat.fill(0.0)
    duration = 0.0
    for k in range(count):
        weight = weights[k] / total
        duration += weight * durations[k]
        row = table[k].reshape(nodes.size)
        for m in range(flat.size):
            flat[m] += weight * row[m]
    return duration / STEPS, duration


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
def trace_half_swings(amplitude, s_end, columns, codes, widths, c, use_map, heads, nodes):  # type: ignore[no-untyped-def]
    """Chain half swings from the turning point (amplitude, s = 0) until s_end or until the rotor sticks.

    heads: (n_max, HEAD + 2 columns) out: start S, step h, duration, amplitude, dA/dq (columns), dS/dq (columns).
    nodes: (n_max, STEPS + 1, fields) out.
    use_map: interpolate half swings in their amplitude (fast) instead of integrating each (direct).
    Returns (count, status): STATUS_OK, STATUS_STUCK (at rest from the last row's start on: that row has duration
    0), STATUS_LOST (no turning point; count rows are valid).
    """
    grad = np.zeros(c.size + 1)
    slope_a = np.zeros(columns)
    slope_s = np.zeros(columns)
    # One band of tabulated half swings per direction of motion.
    grids = np.zeros((2, _BAND_NODES))
    durations = np.zeros((2, _BAND_NODES))
    tables = np.zeros((2, _BAND_NODES, STEPS + 1, nodes.shape[2]))
    low = np.zeros(2)
    high = np.zeros(2)  # no amplitude lies between 0 and 0: no table yet
    weights = np.empty(_BAND_NODES)
    slope_a[0] = 1.0
    start = 0.0
    carry = 0.0  # compensated sum: the start times are what the phase accuracy of 1e-9 rests on
    guess = math.pi
    loss = 0.0
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
        size = abs(amplitude)
        if size > _WIDEST:
            return count, STATUS_LOST
        side = 0 if sigma > 0.0 else 1
        mapped = use_map and sigma * amplitude < 0.0 and low[side] <= size <= high[side]
        if use_map and sigma * amplitude < 0.0 and not mapped and loss > 0.0:
            # A table costs as much as its nodes: worth it only if more half swings than that will use it.
            left = (s_end - start) / guess
            if min(left, size * (1.0 - 1.0 / _BAND_RATIO) / loss) > 4.0 * _BAND_NODES:
                low[side] = max(size / _BAND_RATIO, size - 1.3 * loss * left)
                high[side] = size
                mapped = _build_band(
                    low[side], size, sigma, columns, codes, widths, c, guess, grids[side], tables[side], durations[side]
                )
                if not mapped:
                    high[side] = 0.0
        if mapped:
            h, duration = _interpolate(size, grids[side], tables[side], durations[side], weights, nodes[count])
        else:
            h, duration = integrate_half_swing(amplitude, sigma, columns, codes, widths, c, guess, nodes[count])
        if duration < 0.0:
            return count, STATUS_LOST
        head[HEAD_STEP] = h
        head[HEAD_DURATION] = duration
        end = nodes[count, STEPS]
        _carry_slopes(end, columns, slope_a, slope_s)
        loss = size - abs(end[0])
        amplitude = end[0]
        guess = duration
        term = duration - carry
        total = start + term
        carry = (total - start) - term
        start = total
        count += 1
    return count, STATUS_LOST
