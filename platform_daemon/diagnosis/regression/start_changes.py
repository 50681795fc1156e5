"""A parameter that changes along a ring-down, as changes of the start.

A parameter's own derivative is, at every moment, what a change of the start would do: d y / d p = a(t) d y / d theta +
b(t) d y / d A, for the angle and for the velocity. What the parameter does between t and t + dt is da and db; with a
course in time it is a(t) = integral of course da. So neither the motion nor its answer is integrated again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from platform_daemon.diagnosis.shots.linearisation import Linearisation, basis_at
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE

_LIMITS = THRESHOLDS.regression
THETA, W, AMPLITUDE = 0, 1, 2  # places among the parameters of a state


@dataclass(frozen=True, kw_only=True)
class StartChanges:
    """By how much each parameter of the motion changes theta and A of the start from one instant to the next.

    Attributes:
        turned, grown: (parameters of the motion, n - 1) between n instants.
    """

    turned: Array
    grown: Array


def start_changes(model: RingDownModel, state: FitState, basis: Array) -> StartChanges:
    """From the basis of angle and velocity (b, n) at n instants."""
    d = state.dynamics
    chain = d.chain(model)
    size = chain.shape[0]
    rows = np.tensordot(chain.T, basis[2 : 2 + 2 * size].reshape(size, 2, -1), 1)
    rows[W, 1] += basis[1] / d.w  # of phi' itself; v is in units of w
    (phi_t, v_t), (phi_a, v_a) = rows[THETA], rows[AMPLITUDE]
    det = phi_t * v_a - v_t * phi_a
    known = np.abs(det) > _LIMITS.rest_determinant * (np.abs(phi_t * v_a) + np.abs(v_t * phi_a) + 1e-300)
    safe = np.where(known, det, 1.0)
    turned = np.where(known, (rows[:, 0] * v_a - rows[:, 1] * phi_a) / safe, 0.0)
    grown = np.where(known, (rows[:, 1] * phi_t - rows[:, 0] * v_t) / safe, 0.0)
    both = known[1:] & known[:-1]
    return StartChanges(turned=np.where(both, np.diff(turned), 0.0), grown=np.where(both, np.diff(grown), 0.0))


def f_nat_column(
    linearisation: Linearisation, model: RingDownModel, state: FitState, course: Callable[[Array], Array]
) -> Array:
    """Change of the channels (channels, m) if f_nat moves along a course, a relative change for times (n,) in s.

    The part that a change of the start explains is left out. linearisation: with its Jacobian, at the same motion;
    model, state: of autonomous torques.  Raises LostTrajectoryError.
    """
    times = linearisation.time_s
    changes = start_changes(model, state, basis_at(linearisation.prepared, model, state, STATE))
    moved = state.dynamics.w * course(0.5 * (times[1:] + times[:-1]))
    column = np.zeros_like(linearisation.signal)
    for place, each in ((THETA, changes.turned), (AMPLITUDE, changes.grown)):
        column[:, 1:] += linearisation.jacobian[place][:, 1:] * np.cumsum(moved * each[W])
    return column
