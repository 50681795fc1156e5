"""The turning points of a long ring-down, walked from half swing to half swing without looking inside."""

from __future__ import annotations

import math

import numpy as np

from .arrays import Array
from .chebyshev import nodes_for, sizes_for
from .models import RingDownModel
from .sampling import STATE
from .swing_chain import BAND_RATIO, HEAD, HEAD_SIDE, HEAD_START, STATUS_NO_TABLE, WALK, WALK_ANGLE, WALK_START
from .swing_chain import walk_swings as walk
from .trace import STATUS_LOST, STATUS_OK
from .trajectory import Dynamics, LostTrajectoryError
from .workspace import EXACT, SwingTables

_SHORTEST = 2.0  # duration of a half swing is pi at least, unless something pushes


def turning_points(model: RingDownModel, dynamics: Dynamics, until_s: float) -> tuple[Array, Array]:
    """(times in s, |angles| in rad) from the anchor to beyond until_s, or to the last before the rotor sticks.

    Raises:
        ValueError: a torque that depends on time has no table of half swings.
        LostTrajectoryError: no oscillation.
    """
    if model.time_dependent:
        raise ValueError(f"the half swings of {model.name} depend on time")
    d, columns = dynamics, 1 + len(model.coefficients)
    s_end = d.w * until_s + d.theta
    torque = columns, model.codes, model.widths, d.dimensionless(model)
    size = abs(d.amplitude)
    tables = SwingTables(nodes_for(size, EXACT), sizes_for(size, BAND_RATIO, EXACT), columns)
    place = np.zeros(WALK + 2 * columns)
    place[WALK_ANGLE] = d.amplitude
    rows = int(max(s_end, 0.0) / _SHORTEST) + 16
    heads, weights = np.empty((rows + 1, HEAD + 2 * columns)), np.empty((rows, tables.weights.size))
    starts, sizes = [], []
    status = STATUS_NO_TABLE
    while status == STATUS_NO_TABLE:
        count, status = walk(
            place, s_end, *torque, model.symmetric, tables.bands, tables.sizes, tables.weights, tables.ends, heads,
            weights,
        )  # fmt: skip
        which = np.where(heads[:count, HEAD_SIDE] > 0.0, 0, 0 if model.symmetric else 1)
        starts.append(heads[:count, HEAD_START].copy())
        # The weights interpolate anything smooth over the sizes, and so the sizes themselves.
        sizes.append(np.sum(weights[:count] * tables.sizes[which], axis=1))
        left = s_end - float(place[WALK_START])
        if status == STATUS_NO_TABLE and not tables.solve(
            float(place[WALK_ANGLE]), left, torque, model.symmetric, STATE
        ):
            status = STATUS_LOST
    if status == STATUS_LOST:
        raise LostTrajectoryError("no further turning point: the motion is not an oscillation")
    if status == STATUS_OK:
        starts.append(place[WALK_START : WALK_START + 1])
        sizes.append(np.array([math.fabs(place[WALK_ANGLE])]))
    return (np.concatenate(starts) - d.theta) / d.w, np.concatenate(sizes)
