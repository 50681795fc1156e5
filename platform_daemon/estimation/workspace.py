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
from .swing_chain import BAND_RATIO, HEAD, STATUS_NO_TABLE, WALK, WALK_ANGLE, WALK_START, tabulate, walk_swings
from .trace import STATUS_LOST, STATUS_STUCK
from .trajectory import EARLIEST, Dynamics, LostTrajectoryError

__all__ = ["COARSE", "EXACT", "Moments", "SwingTables", "Workspace"]

EXACT = 9.5  # digits
COARSE = 5.5
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

    def solve(self, angle: float, left: float, torque: Torque, symmetric: bool, observable: int) -> bool:
        """Tabulate the half swings that begin like the one from `angle`; False if there is no turning point."""
        side = math.copysign(1.0, -angle)
        which = 0 if symmetric or side > 0.0 else 1
        g = self.grid
        return bool(
            tabulate(
                abs(angle), left, side, symmetric, *torque, observable, g.nodes, g.once, g.twice, self.bands[which],
                self.sizes[which], self.accelerations[which], self.values[which], self.ends[which],
            )
        )  # fmt: skip


class _Pass:
    """One pass over the samples, from table to table."""

    def __init__(
        self, d: Dynamics, y: Array, first: int, last: int, dt_s: float, observable: int, stride: int, columns: int
    ) -> None:
        self._y, self._window, self._clock = y, (first, last), (dt_s, float(d.w), float(d.theta))
        self._observable, self._stride, self._columns = observable, stride, columns
        self._s_end = d.w * (last - 1) * dt_s + d.theta
        self._walk = np.zeros(WALK + 2 * columns)
        self._walk[WALK_ANGLE], self._walk[WALK] = d.amplitude, math.copysign(1.0, d.amplitude)
        self._rows = int(self._s_end / _SHORTEST) + 16
        self._heads = np.empty((self._rows + 1, HEAD + 2 * columns))
        self._skipped = 0
        b = 7 + 2 * columns
        self._sums = np.zeros((b, b)), np.zeros((y.shape[0], b)), np.zeros(y.shape[0])
        self.used = 0

    @property
    def angle(self) -> float:
        """Where the next half swing begins."""
        return float(self._walk[WALK_ANGLE])

    @property
    def left(self) -> float:
        """Dimensionless time from there to the end."""
        return float(self._s_end - self._walk[WALK_START])

    def advance(self, tables: SwingTables, torque: Torque, symmetric: bool) -> int:
        """Go on as far as the tables reach; why it ended (walk_swings)."""
        weights = np.empty((self._rows, tables.weights.size))
        count, status = walk_swings(
            self._walk, self._s_end, *torque, symmetric, tables.bands, tables.sizes, tables.weights, tables.ends,
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
        y = self._y[:, max(first, math.ceil((self._walk[WALK_START] - theta) / (w * dt_s))) : last]
        gram, products, energy = self._sums
        constant = np.zeros(gram.shape[0])
        constant[-1] = 1.0
        if self._observable != DIPOLE:
            angle = self.angle
            constant[0] = angle
            constant[6:-1:2] = math.copysign(1.0, angle) * self._walk[WALK : WALK + self._columns]
        gram += y.shape[1] * np.outer(constant, constant)
        products += np.outer(y.sum(axis=1), constant)
        energy += np.sum(y**2, axis=1)
        self.used += y.shape[1]

    def result(self) -> Moments:
        """What was collected."""
        gram, products, energy = self._sums
        # Only the lower triangle was filled.
        gram = np.tril(gram) + np.tril(gram, -1).T
        slopes = self._walk[WALK + self._columns :].copy()
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
        tables = self._tables_for(abs(d.amplitude), digits, tabulated)
        tables.bands.fill(0.0)
        torque = self.columns, self._codes, self._widths, d.dimensionless(self.model)
        while (status := pass_.advance(tables, torque, self._symmetric)) == STATUS_NO_TABLE:
            if not tables.solve(pass_.angle, pass_.left, torque, self._symmetric, observable):
                status = STATUS_LOST
                break
        if status == STATUS_STUCK:
            pass_.rest()
        if status == STATUS_LOST or pass_.used == 0:
            raise LostTrajectoryError("no further turning point: the motion is not an oscillation")
        later = pass_.result()
        if direct_to == first:
            return later
        return direct_moments(self.model, d, y, first, direct_to, dt_s, observable).followed_by(later)

    def _tables_for(self, amplitude: float, digits: float, tabulated: bool) -> SwingTables:
        key = nodes_for(amplitude, digits), sizes_for(amplitude, BAND_RATIO, digits) if tabulated else 1
        if key not in self._tables:
            self._tables[key] = SwingTables(*key, self.columns)
        return self._tables[key]
