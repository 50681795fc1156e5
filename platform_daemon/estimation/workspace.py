"""Moments of a window with a trajectory: picks the grids, and keeps tables and buffers between the passes of a fit."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from .arrays import Array
from .chebyshev import grid, nodes_for, size_weights, sizes_for
from .direct_moments import Moments, direct_moments
from .models import RingDownModel
from .moments import BAND_RATIO, collect_moments
from .trace import STATUS_LOST
from .trajectory import EARLIEST, Dynamics, LostTrajectoryError

__all__ = ["COARSE", "EXACT", "Moments", "Workspace"]

EXACT = 9.5  # digits
COARSE = 5.5


class _Tables:
    """Tables of half swings for one pair of grid sizes."""

    def __init__(self, nodes: int, sizes: int, columns: int) -> None:
        g = grid(nodes)
        # What the kernel takes, in its order.
        self.grid = (g.nodes, g.to_nodes, g.once, g.twice, size_weights(sizes))
        self.sizes = np.zeros((2, sizes))
        self.accelerations = np.zeros((2, sizes, nodes))
        self.values = np.zeros((2, sizes, 4 + 2 * columns, nodes))
        self.ends = np.zeros((2, sizes, 2 + 2 * columns))


@dataclass
class Workspace:
    """Everything that passes over the same record with the same model can share."""

    model: RingDownModel
    _tables: dict[tuple[int, int], _Tables] = field(default_factory=dict)

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
            raise LostTrajectoryError(
                "the trajectory must begin no later than half a swing after t = 0, within 180 deg"
            )
        first, last = int(first), int(last)
        # The table knows half swings from their beginning on only, and nothing of time.
        anchored = min(last, max(first, math.ceil(-d.theta / (d.w * dt_s)))) if d.theta < 0.0 else first
        begin = last if self.model.time_dependent else anchored
        direct = direct_moments(self.model, d, y, first, begin, dt_s, observable) if begin > first else None
        if begin == last:
            assert direct is not None
            return direct
        later = self._from_anchor(d, y, begin, last, dt_s, observable, stride, digits, tabulated)
        return later if direct is None else direct.followed_by(later)

    def _from_anchor(
        self,
        d: Dynamics,
        y: Array,
        first: int,
        last: int,
        dt_s: float,
        observable: int,
        stride: int,
        digits: float,
        tabulated: bool,
    ) -> Moments:
        """Moments of samples that follow the anchor, of a torque that does not depend on time."""
        t = self._tables_for(abs(d.amplitude), digits, tabulated)
        b = 7 + 2 * self.columns
        gram, products, energy = np.empty((b, b)), np.empty((y.shape[0], b)), np.empty(y.shape[0])
        slopes = np.empty(self.columns)
        status, used = collect_moments(
            y, first, last, float(dt_s), float(d.w), float(d.theta), float(d.amplitude),
            self.columns, self._codes, self._widths, d.dimensionless(self.model), self._symmetric, observable, stride,
            *t.grid, t.sizes, t.accelerations, t.values, t.ends,
            gram, products, energy, slopes,
        )  # fmt: skip
        if status == STATUS_LOST or used == 0:
            raise LostTrajectoryError("no further turning point: the motion is not an oscillation")
        return Moments(gram, products, energy, used, slopes)

    def _tables_for(self, amplitude: float, digits: float, tabulated: bool) -> _Tables:
        key = nodes_for(amplitude, digits), sizes_for(amplitude, BAND_RATIO, digits) if tabulated else 1
        if key not in self._tables:
            self._tables[key] = _Tables(*key, self.columns)
        return self._tables[key]
