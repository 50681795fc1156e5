"""Half swing after half swing through a ring-down, by tables that are made on the way."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from .arrays import Array, IntArray
from .chebyshev import grid, size_weights
from .models import RingDownModel
from .sampling import DIPOLE
from .swing_chain import HEAD, STATUS_NO_TABLE, WALK, WALK_ANGLE, WALK_START, remaining_sizes, walk_swings
from .swing_table import build_table
from .trace import STATUS_LOST, STATUS_OK, STATUS_STUCK
from .trajectory import Dynamics

_SHORTEST = 2.0  # duration of a half swing is pi at least, unless something pushes

Torque = tuple[int, IntArray, IntArray, Array]


class SwingTables:
    """Tables of half swings for one pair of grid sizes."""

    def __init__(self, nodes: int, sizes: int, columns: int) -> None:
        self.grid = grid(nodes)
        self.barycentric = size_weights(sizes)
        # By direction; one serves both if the torque is symmetric. What an earlier pass left is the best first guess.
        self.bands = np.zeros((2, 3))
        self.sizes = np.zeros((2, sizes))
        self.values = np.zeros((2, sizes, 4 + 2 * columns, nodes))
        self.accelerations = np.zeros((2, sizes, nodes))
        self.ends = np.zeros((2, sizes, 2 + 2 * columns))


class Walk:
    """A ring-down from its anchor to the dimensionless time s_end (swing_chain.py).

    Attributes:
        at: where it stands.
        heads, weights: of the half swings passed in the last stretch; the weights interpolate over the table's sizes.
        status: why that stretch ended (walk_swings); STATUS_LOST if no further turning point was found.
    """

    def __init__(self, model: RingDownModel, d: Dynamics, s_end: float) -> None:
        self._s_end, self._symmetric = s_end, model.symmetric
        self.columns = columns = 1 + len(model.coefficients)
        self._torque: Torque = columns, model.codes, model.widths, d.dimensionless(model)
        self.at = np.zeros(WALK + 2 * columns)
        self.at[WALK_ANGLE], self.at[WALK] = d.amplitude, math.copysign(1.0, d.amplitude)
        self._rows = int(max(s_end, 0.0) / _SHORTEST) + 16
        self.heads = np.empty((self._rows + 1, HEAD + 2 * columns))
        self.weights = np.empty((0, 0))
        self.status: int = STATUS_NO_TABLE

    @property
    def angle(self) -> float:
        """Where the next half swing begins."""
        return float(self.at[WALK_ANGLE])

    def at_rest(self, observable: int) -> Array:
        """The basis (sampling.py) of a rotor that is stuck, (n_basis,): dm/dt is silent, an angle is constant."""
        constant = np.zeros(7 + 2 * self.columns)
        constant[-1] = 1.0
        if observable != DIPOLE:
            constant[0] = self.angle
            constant[6:-1:2] = math.copysign(1.0, self.angle) * self.at[WALK : WALK + self.columns]
        return constant

    def reaches(self, s_end: float) -> bool:
        """True if it has ended, and not before s_end."""
        return self.status == STATUS_STUCK or (self.status == STATUS_OK and float(self.at[WALK_START]) >= s_end)

    def band(self, ratio: float) -> tuple[float, float]:
        """Sizes (low, high) of the half swings that are left, no further apart than `ratio`; 1: the next only."""
        size = abs(self.angle)
        if ratio <= 1.0:
            return size, size
        left = self._s_end - float(self.at[WALK_START])
        low, high = remaining_sizes(size, left, math.copysign(1.0, -self.angle), *self._torque[1:], ratio)
        return float(low), float(high)

    def stretches(
        self, tables: SwingTables, ratio: float, observable: int, digits: float, band: tuple[float, float] | None = None
    ) -> Iterator[int]:
        """Half swings passed, from table to table; afterwards `status` says why the last stretch ended.

        band: of the first stretch, if it is known already.
        """
        self.status = STATUS_NO_TABLE
        settled = 10.0 ** (-0.8 * digits)
        while self.status == STATUS_NO_TABLE:
            pull = self._tabulate(tables, band or self.band(ratio), observable, settled)
            band = None
            self.weights = np.empty((self._rows, tables.barycentric.size))
            count, self.status = walk_swings(
                self.at, self._s_end, *self._torque, self._symmetric, tables.bands, tables.sizes, tables.barycentric,
                tables.ends, self.heads, self.weights,
            )  # fmt: skip
            # Where there is no turning point, it may rest.
            if self.status == STATUS_NO_TABLE and math.isnan(pull):
                self.status = STATUS_LOST
            yield count

    def _tabulate(self, tables: SwingTables, band: tuple[float, float], observable: int, settled: float) -> float:
        """Tables for the half swings of this band on this side; the pull that build_table returns."""
        side = math.copysign(1.0, -self.angle)
        which = 0 if self._symmetric or side > 0.0 else 1
        g = tables.grid
        pull: float = build_table(
            *band, 1.0 if self._symmetric else side, *self._torque, observable, settled, g.nodes, g.once, g.twice,
            tables.sizes[which], tables.accelerations[which], tables.values[which], tables.ends[which],
        )  # fmt: skip
        tables.bands[which] = *band, pull
        return pull
