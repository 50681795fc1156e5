"""Moments of a window with a trajectory: picks the grids, and keeps tables between the passes of a fit."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from .arrays import Array, IntArray
from .chebyshev import grid, nodes_for, size_weights, sizes_for
from .direct_moments import Moments, direct_moments
from .models import RingDownModel
from .moments import collect_swings
from .sampling import DIPOLE
from .swing_chain import HEAD, STATUS_NO_TABLE, WALK, WALK_ANGLE, WALK_START, remaining_sizes, walk_swings
from .swing_table import build_table
from .trace import STATUS_LOST, STATUS_STUCK
from .trajectory import EARLIEST, Dynamics, LostTrajectoryError

__all__ = ["COARSE", "EXACT", "WIDEST_BAND", "Moments", "SwingTables", "Workspace"]

EXACT = 9.5  # digits
COARSE = 5.5
WIDEST_BAND = 4.5
_ROOM = 1.05  # that a table has for the parameters to change before it needs another number of sizes
_SHORTEST = 2.0  # duration of a half swing is pi at least, unless something pushes

Torque = tuple[int, IntArray, IntArray, Array]


class SwingTables:
    """Tables of half swings for one pair of grid sizes."""

    def __init__(self, nodes: int, sizes: int, columns: int) -> None:
        self.grid = grid(nodes)
        self.weights = size_weights(sizes)
        # By direction; one serves both if the torque is symmetric. What an earlier pass left is the best first guess.
        self.bands = np.zeros((2, 2))
        self.sizes = np.zeros((2, sizes))
        self.accelerations = np.zeros((2, sizes, nodes))
        self.values = np.zeros((2, sizes, 4 + 2 * columns, nodes))
        self.ends = np.zeros((2, sizes, 2 + 2 * columns))

    def solve(
        self, walk: Array, s_end: float, ratio: float, torque: Torque, symmetric: bool, observable: int, digits: float
    ) -> bool:
        """Tabulate the half swings left from `walk` (swing_chain.py) on, on its side, in a band up to `ratio` wide.

        digits: that the solutions must have. Returns False if there is no turning point.
        """
        side = math.copysign(1.0, -walk[WALK_ANGLE])
        which = 0 if symmetric or side > 0.0 else 1
        band = self.bands[which] = remaining_band(walk, s_end, ratio, torque)
        settled = 10.0 ** (-0.8 * digits)
        g = self.grid
        return bool(
            build_table(
                band[0], band[1], 1.0 if symmetric else side, *torque, observable, settled, g.nodes, g.once, g.twice,
                self.sizes[which], self.accelerations[which], self.values[which], self.ends[which],
            )
        )  # fmt: skip


def remaining_band(walk: Array, s_end: float, ratio: float, torque: Torque) -> Array:
    """Sizes (low, high) of the half swings left from `walk` on, no further apart than `ratio`; 1: the next only."""
    angle = float(walk[WALK_ANGLE])
    band = np.array([abs(angle), abs(angle)])
    if ratio > 1.0:
        left = s_end - float(walk[WALK_START])
        remaining_sizes(abs(angle), left, math.copysign(1.0, -angle), *torque[1:], ratio, band)
    return band


class _Pass:
    """One pass over the samples, from table to table."""

    def __init__(
        self, d: Dynamics, y: Array, first: int, last: int, dt_s: float, observable: int, stride: int, columns: int
    ) -> None:
        self._y, self._window, self._clock = y, (first, last), (dt_s, float(d.w), float(d.theta))
        self._observable, self._stride, self._columns = observable, stride, columns
        self.s_end = d.w * (last - 1) * dt_s + d.theta
        self.walk = np.zeros(WALK + 2 * columns)
        self.walk[WALK_ANGLE], self.walk[WALK] = d.amplitude, math.copysign(1.0, d.amplitude)
        self._rows = int(self.s_end / _SHORTEST) + 16
        self._heads = np.empty((self._rows + 1, HEAD + 2 * columns))
        self._skipped = 0
        b = 7 + 2 * columns
        self._sums = np.zeros((b, b)), np.zeros((y.shape[0], b)), np.zeros(y.shape[0])
        self.used = 0

    def advance(self, tables: SwingTables, torque: Torque, symmetric: bool) -> int:
        """Go on as far as the tables reach; why it ended (walk_swings)."""
        weights = np.empty((self._rows, tables.weights.size))
        count, status = walk_swings(
            self.walk, self.s_end, *torque, symmetric, tables.bands, tables.sizes, tables.weights, tables.ends,
            self._heads, weights,
        )  # fmt: skip
        if count:
            self.used += collect_swings(
                self._y, *self._window, *self._clock, self._skipped, self._stride, count, self._heads, weights,
                symmetric, self._observable, tables.grid.nodes, tables.grid.to_nodes, tables.values, *self._sums,
            )  # fmt: skip
        self._skipped += count
        return int(status)

    def rest(self) -> None:
        """The remaining samples of a rotor that is stuck: dm/dt is silent, an angle is constant."""
        dt_s, w, theta = self._clock
        first, last = self._window
        y = self._y[:, max(first, math.ceil((self.walk[WALK_START] - theta) / (w * dt_s))) : last]
        gram, products, energy = self._sums
        constant = np.zeros(gram.shape[0])
        constant[-1] = 1.0
        if self._observable != DIPOLE:
            angle = float(self.walk[WALK_ANGLE])
            constant[0] = angle
            constant[6:-1:2] = math.copysign(1.0, angle) * self.walk[WALK : WALK + self._columns]
        gram += y.shape[1] * np.outer(constant, constant)
        products += np.outer(y.sum(axis=1), constant)
        energy += np.sum(y**2, axis=1)
        self.used += y.shape[1]

    def result(self) -> Moments:
        """What was collected."""
        gram, products, energy = self._sums
        # Only the lower triangle was filled.
        gram = np.tril(gram) + np.tril(gram, -1).T
        slopes = self.walk[WALK + self._columns :].copy()
        return Moments(gram, products, energy, self.used, slopes)


@dataclass
class Workspace:
    """Everything that passes over the same record with the same model can share."""

    model: RingDownModel
    _tables: dict[tuple[int, int], SwingTables] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.columns = 1 + len(self.model.coefficients)
        self._codes, self._widths = self.model.codes, self.model.widths
        self._symmetric = self.model.symmetric

    def moments(
        self, dynamics: Dynamics, y: Array, first: int, last: int, dt_s: float, observable: int, stride: int = 1,
        digits: float = EXACT, tabulated: bool = True,
    ) -> Moments:  # fmt: skip
        """Moments of samples first .. last-1 of y (channels, n), or of every stride-th (odd) half swing of them.

        digits: to how many the trajectory is represented.
        Torques that depend on time take the direct path, which knows neither stride nor digits.
        tabulated: look half swings up in a table of sizes; False: solve each for itself, worth it for a few.

        Raises:
            LostTrajectoryError: the parameters describe no oscillation.
        """
        d = dynamics
        if not (np.isfinite(d.w * last * dt_s + d.theta) and 0.0 < abs(d.amplitude) < np.pi and d.theta >= EARLIEST):
            raise LostTrajectoryError("the trajectory must pass a turning point within half a swing of t = 0")
        first, last = int(first), int(last)
        # The tables know half swings from their beginning on only, and nothing of time.
        direct_to = first if d.theta >= 0.0 else min(last, max(first, math.ceil(-d.theta / (d.w * dt_s))))
        if self.model.time_dependent or direct_to == last:
            return direct_moments(self.model, d, y, first, last, dt_s, observable)
        pass_ = _Pass(d, y, direct_to, last, float(dt_s), observable, stride, self.columns)
        torque = self.columns, self._codes, self._widths, d.dimensionless(self.model)
        ratio = WIDEST_BAND if tabulated else 1.0
        band = remaining_band(pass_.walk, pass_.s_end, ratio, torque)
        # The first table sets the width of those that may follow.
        ratio = min(ratio, _ROOM * band[1] / band[0])
        tables = self._tables_for(abs(d.amplitude), ratio, digits)
        tables.bands.fill(0.0)
        status = STATUS_NO_TABLE
        while status == STATUS_NO_TABLE:
            if not tables.solve(pass_.walk, pass_.s_end, ratio, torque, self._symmetric, observable, digits):
                status = STATUS_LOST
                break
            status = pass_.advance(tables, torque, self._symmetric)
        if status == STATUS_STUCK:
            pass_.rest()
        if status == STATUS_LOST or pass_.used == 0:
            raise LostTrajectoryError("no further turning point: the motion is not an oscillation")
        later = pass_.result()
        if direct_to == first:
            return later
        return direct_moments(self.model, d, y, first, direct_to, dt_s, observable).followed_by(later)

    def _tables_for(self, amplitude: float, ratio: float, digits: float) -> SwingTables:
        key = nodes_for(amplitude, digits), sizes_for(amplitude, ratio, digits)
        if key not in self._tables:
            self._tables[key] = SwingTables(*key, self.columns)
        return self._tables[key]
