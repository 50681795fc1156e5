"""Which half cycles the next table of a ring-down holds: those that are left, no further apart than makes sense."""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.chebyshev import MOST_SIZES, sizes_for
from platform_daemon.estimation.numerics.jit import part
from platform_daemon.estimation.physics.torques.dispatch import acceleration
from platform_daemon.estimation.thresholds import THRESHOLDS

LIMITS = THRESHOLDS.physics
_WIDEST_BAND = LIMITS.widest_band
_ROOM = LIMITS.band_room
_MARGIN = LIMITS.band_margin
_POINTS = LIMITS.band_points
_LEAST_SINE = LIMITS.band_least_sine
_SLACK = LIMITS.band_slack_share
_MOST_GROWTH = LIMITS.band_most_growth

# Position of a walk through a ring-down, float64 (WALK + 2 columns,): start S of the next half cycle, its rounding
# error, the angle; how wide a band a table covers and at how many sizes, 0 before the first; d size/dq, d S/dq.
WALK_START, WALK_CARRY, WALK_ANGLE, WALK_RATIO, WALK_SIZES, WALK = 0, 1, 2, 3, 4, 5


@part
def next_band(walk, s_end, codes, widths, c, digits):  # type: ignore[no-untyped-def]
    """Smallest and largest size of the half cycles left until s_end, and at how many sizes to tabulate them.

    The first band sets width and number for those that follow, in `walk`. One size: the next half cycle only.
    """
    angle = walk[WALK_ANGLE]
    size = abs(angle)
    if walk[WALK_SIZES] == 1.0:
        return size, size, 1
    first = walk[WALK_SIZES] == 0.0
    ratio = _WIDEST_BAND if first else walk[WALK_RATIO]
    left = s_end - walk[WALK_START]
    low, high = remaining_sizes(size, left, -math.copysign(1.0, angle), codes, widths, c, ratio)
    if first:
        walk[WALK_RATIO] = min(_WIDEST_BAND, _ROOM * high / low)
        # A term with a scale of its own changes faster with the size than the orbit does.
        scaled = widths.max() > 1
        walk[WALK_SIZES] = MOST_SIZES if scaled else sizes_for(size, walk[WALK_RATIO], digits)
    return low, high, int(walk[WALK_SIZES])


@part
def remaining_sizes(size, left, side, codes, widths, c, ratio):  # type: ignore[no-untyped-def]
    """Smallest and largest size of the half cycles in the remaining time `left`.

    An estimate from the work of the losses in one of them, no wider than size/ratio to 1.5 size: a ring-down that
    leaves the band gets another table.
    """
    grad = np.zeros(c.size + 1)
    points = _POINTS
    work = 0.0
    for k in range(points):
        place = math.pi * (k + 0.5) / points
        phi = -size * math.cos(place)
        v = math.sqrt(2.0 * (math.cos(phi) - math.cos(size)))
        there, _, _ = acceleration(side * phi, side * v, side, codes, widths, c, grad)
        back, _, _ = acceleration(side * phi, -side * v, -side, codes, widths, c, grad)
        # What changes sign with the motion is not conservative.
        work += 0.5 * side * (there - back) * math.sin(place) * size * math.pi / points
    change = _MARGIN * (left / math.pi + 2.0) * work / max(math.sin(size), _LEAST_SINE * size)
    low = max(size / ratio, size + min(change, 0.0) - _SLACK * size)
    return low, min(_MOST_GROWTH * size, size + max(change, 0.0) + _SLACK * size)
