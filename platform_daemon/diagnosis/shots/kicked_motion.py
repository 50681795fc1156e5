"""A swing whose velocity is changed at known instants, exactly: from each kick on it is another swing of the same
equation of motion.

From a kick at t0 of s rad/s on, the motion has another start (theta2, A2), which follows from the state at t0:

    x2(t0; theta2, w, A2, c) = x1(t0; theta, w, A, c) + (0, s / w),    x = (phi, phi' / w).

Its derivatives by the parameters p of the first start follow from those by its own by the chain rule, with

    d(theta2, A2)/dp = (dx2/d(theta2, A2))^-1 (dx1/dp - dx2/dp - [p = w] (0, s / w^2)).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.moments.workspace import Workspace
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.ring_down import dynamics_through
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError, MotionParameters

_THETA, _W, _AMPLITUDE = 0, 1, 2  # places of the derivatives in a basis
_ROUNDING_S = 1e-9  # of the instant of a sample


@dataclass(frozen=True)
class Kick:
    """A change of the velocity: when, s after the first sample, and by how much, rad/s."""

    time_s: float
    speed_rad_per_s: float


@dataclass(frozen=True)
class KickedState(FitState):
    """A state with the kicks of its shot, in the order of their times."""

    kicks: tuple[Kick, ...]

    def moved(self, step: Array) -> KickedState:
        """The state after a step, with the same kicks."""
        own = FitState.moved(self, step)
        return KickedState(own.dynamics, own.observation, own.offsets, self.kicks)


def kicks_of(state: FitState) -> tuple[Kick, ...]:
    """Of a state that has some."""
    return state.kicks if isinstance(state, KickedState) else ()


@dataclass(frozen=True)
class _Stretch:
    """A swing between two kicks.

    motion: with its own start, theta counted from `origin_s`; by_start: (2, parameters) derivatives of its theta and A
    by the first one's parameters theta, w, A, c.
    """

    motion: MotionParameters
    origin_s: float
    by_start: Array

    def samples(self, model: RingDownModel, first: int, last: int, dt_s: float, observable: int) -> tuple[Array, Array]:
        """(rows, n) by the parameters of the first start, and (2, n) by theta of its own, at origin_s + n dt_s."""
        own = Workspace(model).basis(self.motion, first, last, dt_s, observable)
        size = self.by_start.shape[1]
        rows = own[2 : 2 + 2 * size].reshape(size, 2, -1)
        moved = np.tensordot(self.by_start.T, rows[[_THETA, _AMPLITUDE]], 1)
        kept = [k for k in range(size) if k not in (_THETA, _AMPLITUDE)]
        moved[kept] += rows[kept]
        return np.concatenate([own[:2], moved.reshape(2 * size, -1), own[2 + 2 * size :]]), rows[_THETA]

    def begun_at(self, model: RingDownModel, time_s: float, speed_rad_per_s: float = 0.0) -> _Stretch:
        """The same swing, or that after a kick, with another origin.  Raises LostTrajectoryError."""
        late_s = time_s - self.origin_s
        if late_s < -_ROUNDING_S:
            raise LostTrajectoryError("a kick comes before the first sample")
        before = self.samples(model, 1, 2, late_s, STATE) if late_s > 0.0 else self.samples(model, 0, 1, 1.0, STATE)
        here, w, size = before[0][:, 0], self.motion.w, self.by_start.shape[1]
        jump = np.array([0.0, speed_rad_per_s / w])
        phi, v = (here[:2] + jump).tolist()
        try:
            motion = dynamics_through(model, w=w, values=self.motion.values, phi=phi, v=v)
            after = Workspace(model).basis(motion, 0, 1, 1.0, STATE)[2 : 2 + 2 * size, 0].reshape(size, 2)
            own = after[[_THETA, _AMPLITUDE]].T
            after[[_THETA, _AMPLITUDE]] = 0.0
            by_parameter = here[2 : 2 + 2 * size].reshape(size, 2) - after
            by_parameter[_W] -= jump / w
            return _Stretch(motion, time_s, np.asarray(np.linalg.solve(own, by_parameter.T), dtype=np.float64))
        except (ValueError, np.linalg.LinAlgError) as error:
            raise LostTrajectoryError(str(error)) from None


def motion_basis(
    model: RingDownModel, state: FitState, first: int, last: int, dt_s: float, observable: int
) -> tuple[Array, Array]:
    """The basis (rows, n) of a state at the times i dt_s, first <= i < last, with its kicks where it has some, and
    (2, n) time derivatives in units of w of its first two rows.

    Raises LostTrajectoryError.
    """
    if isinstance(state, KickedState):
        return kicked_basis(model, state, first, last, dt_s, observable)
    basis = Workspace(model).basis(state.dynamics, first, last, dt_s, observable)
    return basis, basis[2 + 2 * _THETA : 4 + 2 * _THETA]


def kicked_basis(
    model: RingDownModel, state: KickedState, first: int, last: int, dt_s: float, observable: int
) -> tuple[Array, Array]:
    """As `Workspace.basis`, (rows, n), and (2, n) time derivatives in units of w of the first two rows.

    Raises LostTrajectoryError, also for torques that depend on time.
    """
    if model.time_dependent:
        raise LostTrajectoryError("a kick beside torques that depend on time has no swing of its own")
    unchanged = np.zeros((2, 3 + len(state.dynamics.values)))
    unchanged[0, _THETA] = unchanged[1, _AMPLITUDE] = 1.0
    stretch = _Stretch(state.dynamics, 0.0, unchanged)
    places = [int(np.clip(np.ceil(kick.time_s / dt_s), first, last)) for kick in state.kicks]
    pieces: list[tuple[Array, Array]] = []
    for k, (begin, end) in enumerate(pairwise([first, *places, last])):
        if k:
            kick = state.kicks[k - 1]
            stretch = stretch.begun_at(model, kick.time_s, kick.speed_rad_per_s)
        if end > begin and k:
            pieces.append(stretch.begun_at(model, begin * dt_s).samples(model, 0, end - begin, dt_s, observable))
        elif end > begin:
            pieces.append(stretch.samples(model, begin, end, dt_s, observable))
    return np.concatenate([basis for basis, _ in pieces], axis=1), np.concatenate([s for _, s in pieces], axis=1)
