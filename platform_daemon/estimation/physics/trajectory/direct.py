"""A ring-down trajectory: the model with values for its dynamics, traced once, then sampled as often as needed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.thresholds import THRESHOLDS

from .basis_functions import fill_basis
from .direct_chain import HEAD, HEAD_DURATION, STATUS_LOST, trace_half_cycles
from .runge_kutta import STEPS

LIMITS = THRESHOLDS.physics
EARLIEST = LIMITS.earliest_anchor


@dataclass(frozen=True, kw_only=True)
class MotionParameters:
    """Smooth internal parameters of the motion.

    Attributes:
        w: natural angular frequency, rad/s.
        theta: dimensionless time w t elapsed at t = 0 since the turning point the trajectory is anchored at;
            negative if that comes after t = 0; the motion then arrives at it, without a turning point in between.
        amplitude: angle at that turning point, rad, with sign.
        values: physical coefficients of the model's terms, in the model's order and units.
    """

    w: float
    theta: float
    amplitude: float
    values: tuple[float, ...]

    def dimensionless(self, model: RingDownModel) -> Array:
        """c = q / w**power for every coefficient, (coefficients,)."""
        return np.array([q / self.w**p for q, p in zip(self.values, model.powers, strict=True)])

    def chain(self, model: RingDownModel) -> Array:
        """d(theta, w, A, c...)/d(theta, w, A, q...), square (3 + coefficients,): the powers of w in c."""
        return _chain(self.w, self.values, model.powers)


@lru_cache(8)
def _chain(w: float, values: tuple[float, ...], powers: tuple[int, ...]) -> Array:
    """The chain of a state, kept because several callers need it."""
    matrix = np.eye(3 + len(values))
    for k, (power, q) in enumerate(zip(powers, values, strict=True), 3):
        matrix[k, k] = w**-power
        matrix[k, 1] = -power * q / w ** (power + 1)
    matrix.flags.writeable = False
    return matrix


class LostTrajectoryError(ArithmeticError):
    """The trajectory found no further turning point: the parameters describe no oscillation."""


class Trajectory:
    """A traced ring-down from its anchor to t_end.

    Args:
        model: the equation of motion.
        dynamics: its parameters.
        t_end_s: the trace reaches at least to this time.

    Raises:
        LostTrajectoryError: no oscillation.
    """

    def __init__(self, model: RingDownModel, dynamics: MotionParameters, t_end_s: float) -> None:
        self.dynamics = dynamics
        self._timed = model.time_dependent
        self.columns = 1 + model.followed + int(self._timed)
        s_end = dynamics.w * t_end_s + dynamics.theta
        if not (np.isfinite(s_end) and np.isfinite(dynamics.amplitude) and dynamics.theta >= EARLIEST):
            raise LostTrajectoryError("the trajectory must begin no later than half a cycle after t = 0")
        rows = int(max(s_end, 0.0) / LIMITS.shortest_half_cycle) + LIMITS.direct_spare_half_cycles
        if rows > LIMITS.most_half_cycles:
            raise LostTrajectoryError("far more half cycles than any record holds")
        self._heads = np.empty((rows, HEAD))
        self._nodes = np.empty((rows, STEPS + 1, 4 + 3 * self.columns))
        self._count, status = trace_half_cycles(
            float(dynamics.amplitude),
            float(dynamics.theta),
            float(s_end),
            self.columns,
            model.codes,
            model.widths,
            dynamics.dimensionless(model),
            self._heads,
            self._nodes,
        )
        if status == STATUS_LOST:
            raise LostTrajectoryError("no further turning point: the motion is not an oscillation")

    def basis(self, first: int, last: int, dt_s: float, observable: int) -> Array:
        """Basis functions (basis_functions.py) at samples first .. last-1, float64 (n_basis, last - first)."""
        d, columns = self.dynamics, self.columns
        out = np.empty((7 + 2 * columns, last - first))
        fill_basis(
            int(first), int(last), float(dt_s), float(d.w), float(d.theta), columns, self._count, self._heads,
            self._nodes, observable, 0, out,
        )  # fmt: skip
        if not self._timed:
            return out
        # theta shifts the whole motion, and says when t = 0 is in it.
        out[2:4] += out[4 + 2 * columns : 6 + 2 * columns]
        return np.delete(out, [4 + 2 * columns, 5 + 2 * columns], axis=0)

    def slopes(self) -> Array:
        """d S/d (A, c) of the last turning point S, (1 + coefficients,)."""
        moved = range(self.columns - int(self._timed))
        for row in range(self._count - 1, -1, -1):
            if self._heads[row, HEAD_DURATION] > 0.0:
                end = self._nodes[row, STEPS]
                return np.array([-end[5 + 3 * q] / end[2] for q in moved])
        return np.zeros(len(moved))
