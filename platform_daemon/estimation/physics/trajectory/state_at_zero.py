"""The state of a ring-down at t = 0, from the one or two half cycles that lead there."""

from __future__ import annotations

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.chebyshev import EXACT, nodes_for
from platform_daemon.estimation.physics.models import RingDownModel

from .basis_functions import STATE
from .direct import LostTrajectoryError, MotionParameters, Trajectory
from .direct_chain import STATUS_LOST, STATUS_STUCK
from .half_cycle_chain import HEAD, HEAD_DURATION, HEAD_SIDE, HEAD_START
from .half_cycle_walk import HalfCycleTables, HalfCycleWalk


def state_at_zero(model: RingDownModel, dynamics: MotionParameters) -> tuple[Array, Array]:
    """(phi, v) at t = 0, (2,), and their derivatives by (theta, w, A, c...), (3 + coefficients, 2).

    Raises:
        LostTrajectoryError: the parameters describe no oscillation.
    """
    d = dynamics
    if model.time_dependent or d.theta < 0.0:
        basis = Trajectory(model, d, 0.0).basis(0, 1, 1.0, STATE)[:, 0]
    else:
        basis = _by_half_cycles(model, d)
    return basis[:2], basis[2:-1].reshape(-1, 2)


def _by_half_cycles(model: RingDownModel, d: MotionParameters) -> Array:
    """The basis (basis_functions.py) at t = 0, (n_basis,)."""
    walk = HalfCycleWalk(model, d, d.theta, one_by_one=True)
    columns = walk.columns
    tables = HalfCycleTables(nodes_for(abs(d.amplitude), EXACT), columns)
    count = [count for count in walk.stretches(tables, STATE, EXACT) if count][-1:]
    if walk.status == STATUS_STUCK:
        return walk.at_rest(STATE)
    if walk.status == STATUS_LOST or not count:
        raise LostTrajectoryError("no further turning point: the motion is not an oscillation")
    head = walk.heads[count[0] - 1]
    side, from_first, shift = head[HEAD_SIDE], head[HEAD : HEAD + columns], head[HEAD + columns :]
    which = 0 if model.symmetric or side > 0.0 else 1
    place = 2.0 * (d.theta - head[HEAD_START]) / head[HEAD_DURATION] - 1.0
    seen = (side * (tables.values[which, 0] @ tables.grid.weights_at(place))).reshape(-1, 2)
    by_motion = from_first[:, None] * seen[2] - shift[:, None] * seen[1]
    by_motion[1:] += seen[3:]
    return np.concatenate([seen[:2].ravel(), np.zeros(2), by_motion.ravel(), np.ones(1)])
