"""Half cycle after half cycle through a ring-down, by tables that are made on the way."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.chebyshev import MOST_SIZES, grid
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.thresholds import THRESHOLDS

from .basis_functions import DIPOLE
from .direct import LostTrajectoryError, MotionParameters
from .direct_chain import STATUS_OK, STATUS_STUCK
from .half_cycle_chain import STATUS_NO_TABLE, walk_half_cycles
from .half_cycle_table import build_table
from .table_range import WALK, WALK_ANGLE, WALK_SIZES, WALK_START

LIMITS = THRESHOLDS.physics


class HalfCycleTables:
    """Room for tables of half cycles on a grid, by direction; one serves both if the torque is symmetric.

    What an earlier walk left is the best first guess.
    """

    def __init__(self, nodes: int, columns: int) -> None:
        self.grid = grid(nodes)
        self.sizes = np.zeros((2, MOST_SIZES))
        self.values = np.empty((2, MOST_SIZES, 4 + 2 * columns, nodes))
        self.accelerations = np.empty((2, MOST_SIZES, nodes))
        self.ends = np.zeros((2, MOST_SIZES, 2 + 2 * columns))


class HalfCycleWalk:
    """A ring-down from its anchor to the dimensionless time s_end (half_cycle_chain.py).

    one_by_one: every half cycle is solved for itself, worth it for a few.

    Attributes:
        columns: of derivatives, by size and by c.
        at: the position of the walk.
        heads, weights: of the half cycles passed in the last stretch; the weights interpolate over the table's sizes.
        status: why that stretch ended (walk_half_cycles).
    """

    def __init__(self, model: RingDownModel, d: MotionParameters, s_end: float, *, one_by_one: bool = False) -> None:
        self._s_end = s_end
        self._symmetric = model.symmetric
        self.columns = columns = 1 + len(model.coefficients)
        self._torque = columns, model.codes, model.widths, d.dimensionless(model), model.symmetric
        self.at = np.zeros(WALK + 2 * columns)
        self.at[WALK_SIZES] = float(one_by_one)
        self.at[WALK_ANGLE], self.at[WALK] = d.amplitude, math.copysign(1.0, d.amplitude)
        self.status: int = STATUS_NO_TABLE

    @property
    def angle(self) -> float:
        """Where the next half cycle begins."""
        return float(self.at[WALK_ANGLE])

    def at_rest(self, observable: int) -> Array:
        """The basis (basis_functions.py) of a stuck rotor, (n_basis,): dm/dt is silent, an angle is constant."""
        constant = np.zeros(7 + 2 * self.columns)
        constant[-1] = 1.0
        if observable != DIPOLE:
            constant[0] = self.angle
            constant[6:-1:2] = math.copysign(1.0, self.angle) * self.at[WALK : WALK + self.columns]
        return constant

    def reaches(self, s_end: float) -> bool:
        """True if it has ended, and not before s_end."""
        return self.status == STATUS_STUCK or (self.status == STATUS_OK and float(self.at[WALK_START]) >= s_end)

    def stretches(self, tables: HalfCycleTables, observable: int, digits: float) -> Iterator[int]:
        """Half cycles passed, from table to table; afterwards `status` says why the last stretch ended.

        digits: to how many the tables are right.

        Raises LostTrajectoryError for far more half cycles than any record holds.
        """
        t = tables
        g = tables.grid
        bands = np.zeros((2, 3))
        self.status = STATUS_NO_TABLE
        while self.status == STATUS_NO_TABLE:
            left = (self._s_end - float(self.at[WALK_START])) / LIMITS.shortest_half_cycle
            if not left < LIMITS.most_half_cycles:  # also where a trial step has led to no number at all
                raise LostTrajectoryError("far more half cycles than any record holds")
            used = build_table(
                self.at, self._s_end, *self._torque, observable, digits, g.nodes, g.once, g.twice, bands, t.sizes,
                t.accelerations, t.values, t.ends,
            )  # fmt: skip
            count, self.status, self.heads, self.weights = walk_half_cycles(
                self.at, self._s_end, *self._torque, used, bands, t.sizes, t.ends
            )
            yield count
