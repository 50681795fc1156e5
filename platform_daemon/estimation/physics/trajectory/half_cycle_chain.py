"""A ring-down as a chain of tabulated half cycles (half_cycle_table.py): where each begins, its duration, its size.

The jump of the sensitivities at a turning point needs no formula of its own: with P(A, c) the next size and D(A, c)
the duration of a half cycle, dS/dq and dA/dq follow from the chain rule.
"""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.jit import kernel, part
from platform_daemon.estimation.physics.torques.dispatch import acceleration
from platform_daemon.estimation.thresholds import THRESHOLDS

from .direct_chain import STATUS_LOST, STATUS_OK, STATUS_STUCK
from .half_cycle_table import look_up_end
from .table_range import WALK, WALK_ANGLE, WALK_CARRY, WALK_START

LIMITS = THRESHOLDS.physics
_SURE_PULL = LIMITS.sure_pull
_SHORTEST = LIMITS.shortest_half_cycle
_WIDEST = LIMITS.widest_rad
_SPARE = LIMITS.spare_half_cycles

STATUS_NO_TABLE = 3
# A half cycle passed, float64 (HEAD + 2 columns,): start S, duration, direction; d size/dq, d S/dq.
HEAD_START, HEAD_DURATION, HEAD_SIDE, HEAD = 0, 1, 2, 3


@kernel
def walk_half_cycles(walk, s_end, columns, codes, widths, c, mirrored, used, bands, sizes, ends):  # type: ignore[no-untyped-def]
    """Pass half cycles from the position `walk`, until s_end, rest or the end of the tables; `walk` moves along.

    By direction, as build_table leaves them: bands (2, 3), sizes (2, .), ends (2, ., 2 + 2 columns), `used` sizes each.
    Returns (count, status, heads, weights): STATUS_OK, STATUS_STUCK (it rests from here on), STATUS_LOST (no turning
    point), STATUS_NO_TABLE (the next half cycle needs another table). A row per half cycle: heads (n, HEAD + 2
    columns), one more with the start of the next, and weights (n - 1, used) to look its values up with.
    """
    grad = np.zeros(c.size + 1)
    end = np.empty(2 + 2 * columns)
    barycentric = _barycentric(used)
    rows = int(max(s_end - walk[WALK_START], 0.0) / _SHORTEST) + _SPARE
    heads = np.empty((rows + 1, HEAD + 2 * columns))
    weights = np.empty((rows, used))
    count = 0
    while True:
        angle = walk[WALK_ANGLE]
        heads[count, HEAD_START] = walk[WALK_START]
        if walk[WALK_START] > s_end:
            return count, STATUS_OK, heads, weights
        size = abs(angle)
        side = -math.copysign(1.0, angle)
        which = 0 if mirrored or side > 0.0 else 1
        tabulated = bands[which, 0] <= size <= bands[which, 1]
        if not (tabulated and bands[which, 2] > _SURE_PULL):
            side = _direction_at_rest(angle, side, codes, widths, c, grad)
            if side == 0.0:
                return count, STATUS_STUCK, heads, weights
        if side * angle >= 0.0 or not size < _WIDEST or count == rows:
            return count, STATUS_LOST, heads, weights
        if not tabulated:
            # Where there is no turning point, it may rest.
            return count, STATUS_LOST if math.isnan(bands[which, 2]) else STATUS_NO_TABLE, heads, weights
        look_up_end(size, sizes[which, :used], barycentric, ends[which], weights[count], end)
        heads[count, HEAD_DURATION] = end[0]
        heads[count, HEAD_SIDE] = side
        for q in range(2 * columns):
            heads[count, HEAD + q] = walk[WALK + q]
        _pass_half_cycle(walk, side, end, columns)
        count += 1


@part
def _barycentric(count):  # type: ignore[no-untyped-def]
    """Barycentric weights of `count` sizes at Chebyshev places, (count,)."""
    weights = np.empty(count)
    for k in range(count):
        weights[k] = (-1.0) ** k * math.sin(math.pi * (2 * k + 1) / (2 * count))
    return weights


@part
def _direction_at_rest(angle, likely, codes, widths, c, grad):  # type: ignore[no-untyped-def]
    """Where a rotor at rest goes: +1, -1, or 0 where friction of either sign holds it."""
    for sign in (likely, -likely):
        pull, _, _ = acceleration(angle, 0.0, sign, codes, widths, c, grad)
        if pull * sign > 0.0:
            return sign
    return 0.0


@part
def _pass_half_cycle(walk, side, end, columns):  # type: ignore[no-untyped-def]
    """Move `walk` over a half cycle with these end values (2 + 2 columns,)."""
    turn = math.copysign(1.0, end[1])  # friction may stop it before it crosses zero: then its size is -end[1]
    for p in range(columns):
        own = 0.0 if p == 0 else 1.0
        walk[WALK + columns + p] += end[2 + columns] * walk[WALK + p] + own * end[2 + columns + p]
        walk[WALK + p] = turn * (end[2] * walk[WALK + p] + own * end[2 + p])
    walk[WALK_ANGLE] = side * end[1]
    # Compensated sum: the start times are what the phase accuracy of 1e-9 rests on.
    term = end[0] - walk[WALK_CARRY]
    total = walk[WALK_START] + term
    walk[WALK_CARRY] = (total - walk[WALK_START]) - term
    walk[WALK_START] = total
