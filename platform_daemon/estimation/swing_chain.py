"""A ring-down as a chain of tabulated half swings (swing_table.py): where each begins, how long it lasts, its size.

The jump of the sensitivities at a turning point needs no formula of its own: with P(A, c) the next size and D(A, c)
the duration of a half swing, dS/dq and dA/dq follow from the chain rule.
"""

from __future__ import annotations

import math

import numpy as np

from .jit import kernel, part
from .swing_table import look_up_end
from .terms.dispatch import acceleration
from .trace import STATUS_LOST, STATUS_OK, STATUS_STUCK

STATUS_NO_TABLE = 3
# Where the walk stands, float64 (WALK + 2 columns,): start S, its rounding error, angle; d size/dq, d S/dq.
WALK_START, WALK_CARRY, WALK_ANGLE, WALK = 0, 1, 2, 3
# A half swing passed, float64 (HEAD + 2 columns,): start S, duration, direction; d size/dq, d S/dq.
HEAD_START, HEAD_DURATION, HEAD_SIDE, HEAD = 0, 1, 2, 3
_SURE_PULL = 0.1  # far enough from sticking that between the sizes nothing can stick either
_MARGIN = 1.15
_WIDEST = 3.0  # rad; close to the inverted position a half swing takes forever


@kernel
def remaining_sizes(size, left, side, codes, widths, c, ratio):  # type: ignore[no-untyped-def]
    """Smallest and largest size of the half swings in the remaining time `left`.

    An estimate from the work of the losses in one of them, no wider than size/ratio to 1.5 size: a ring-down that
    leaves the band gets another table.
    """
    grad = np.zeros(c.size + 1)
    points = 8
    work = 0.0
    for k in range(points):
        place = math.pi * (k + 0.5) / points
        phi = -size * math.cos(place)
        v = math.sqrt(2.0 * (math.cos(phi) - math.cos(size)))
        there, _, _ = acceleration(side * phi, side * v, side, codes, widths, c, grad)
        back, _, _ = acceleration(side * phi, -side * v, -side, codes, widths, c, grad)
        # What changes sign with the motion is not conservative.
        work += 0.5 * side * (there - back) * math.sin(place) * size * math.pi / points
    change = _MARGIN * (left / math.pi + 2.0) * work / max(math.sin(size), 0.1 * size)
    low = max(size / ratio, size + min(change, 0.0) - 1e-3 * size)
    return low, min(1.5 * size, size + max(change, 0.0) + 1e-3 * size)


@kernel
def walk_swings(  # type: ignore[no-untyped-def]
    walk, s_end, columns, codes, widths, c, mirrored, bands, sizes, barycentric, ends, heads, weights
):
    """Pass half swings from where `walk` stands, until s_end, rest or the end of the tables; `walk` moves along.

    bands (2, 3): smallest size, largest, and the smallest pull back over the largest (build_table); sizes (2, k),
    ends (2, k, 2 + 2 columns): tables by direction. Out, a row per half swing: heads (n, HEAD + 2 columns), one more
    with the start of the next, and weights (n - 1, k) to look its values up with.
    Returns (count, status): STATUS_OK, STATUS_STUCK (it rests from here on), STATUS_LOST (no turning point),
    STATUS_NO_TABLE (the next half swing needs another table).
    """
    grad = np.zeros(c.size + 1)
    end = np.empty(2 + 2 * columns)
    count = 0
    while True:
        angle = walk[WALK_ANGLE]
        heads[count, HEAD_START] = walk[WALK_START]
        if walk[WALK_START] > s_end:
            return count, STATUS_OK
        size = abs(angle)
        side = -math.copysign(1.0, angle)
        which = 0 if mirrored or side > 0.0 else 1
        tabulated = bands[which, 0] <= size <= bands[which, 1]
        if not (tabulated and bands[which, 2] > _SURE_PULL):
            side = _direction_at_rest(angle, side, codes, widths, c, grad)
            if side == 0.0:
                return count, STATUS_STUCK
        if side * angle >= 0.0 or not size < _WIDEST or count == weights.shape[0]:
            return count, STATUS_LOST
        if not tabulated:
            return count, STATUS_NO_TABLE
        look_up_end(size, sizes[which], barycentric, ends[which], weights[count], end)
        heads[count, HEAD_DURATION] = end[0]
        heads[count, HEAD_SIDE] = side
        for q in range(2 * columns):
            heads[count, HEAD + q] = walk[WALK + q]
        _pass(walk, side, end, columns)
        count += 1


@part
def _direction_at_rest(angle, likely, codes, widths, c, grad):  # type: ignore[no-untyped-def]
    """Where a rotor at rest goes: +1, -1, or 0 where friction of either sign holds it."""
    for sign in (likely, -likely):
        pull, _, _ = acceleration(angle, 0.0, sign, codes, widths, c, grad)
        if pull * sign > 0.0:
            return sign
    return 0.0


@part
def _pass(walk, side, end, columns):  # type: ignore[no-untyped-def]
    """Move `walk` over a half swing with these end values (2 + 2 columns,)."""
    for p in range(columns):
        own = 0.0 if p == 0 else 1.0
        walk[WALK + columns + p] += end[2 + columns] * walk[WALK + p] + own * end[2 + columns + p]
        walk[WALK + p] = end[2] * walk[WALK + p] + own * end[2 + p]
    walk[WALK_ANGLE] = side * end[1]
    # Compensated sum: the start times are what the phase accuracy of 1e-9 rests on.
    term = end[0] - walk[WALK_CARRY]
    total = walk[WALK_START] + term
    walk[WALK_CARRY] = (total - walk[WALK_START]) - term
    walk[WALK_START] = total
