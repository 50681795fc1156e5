"""The turning points of a long ring-down, walked from half cycle to half cycle without looking inside."""

from __future__ import annotations

import math

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.chebyshev import EXACT, nodes_for
from platform_daemon.estimation.physics.models import RingDownModel

from .basis_functions import STATE
from .direct import LostTrajectoryError, MotionParameters
from .direct_chain import STATUS_LOST, STATUS_OK
from .half_cycle_chain import HEAD_SIDE, HEAD_START
from .half_cycle_walk import HalfCycleTables, HalfCycleWalk
from .table_range import WALK_START


def turning_points(model: RingDownModel, dynamics: MotionParameters, until_s: float) -> tuple[Array, Array]:
    """(times in s, |angles| in rad) from the anchor to beyond until_s, or to the last before the rotor sticks.

    Raises:
        ValueError: a torque that depends on time has no table of half cycles.
        LostTrajectoryError: no oscillation.
    """
    if model.time_dependent:
        raise ValueError(f"the half cycles of {model.name} depend on time")
    d = dynamics
    walk, size = HalfCycleWalk(model, d, d.w * until_s + d.theta), abs(d.amplitude)
    tables = HalfCycleTables(nodes_for(size, EXACT), walk.columns)
    starts, sizes = [], []
    for count in walk.stretches(tables, STATE, EXACT):
        which = np.where(walk.heads[:count, HEAD_SIDE] > 0.0, 0, 0 if model.symmetric else 1)
        starts.append(walk.heads[:count, HEAD_START].copy())
        # The weights interpolate anything smooth over the sizes, and so the sizes themselves.
        sizes.append(np.sum(walk.weights[:count] * tables.sizes[which, : walk.weights.shape[1]], axis=1))
    if walk.status == STATUS_LOST:
        raise LostTrajectoryError("no further turning point: the motion is not an oscillation")
    if walk.status == STATUS_OK:
        starts.append(walk.at[WALK_START : WALK_START + 1])
        sizes.append(np.array([math.fabs(walk.angle)]))
    return (np.concatenate(starts) - d.theta) / d.w, np.concatenate(sizes)
