"""Moments of a window with a trajectory: picks the grids, and keeps tables between the passes of a fit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from .arrays import Array
from .basis_table import fill_basis_from_table
from .chebyshev import nodes_for, sizes_for
from .direct_moments import Moments, direct_moments
from .models import RingDownModel
from .moments import collect_swings
from .residual_trace import fill_model, points_in, to_coefficients
from .sampling import DIPOLE
from .swing_chain import WALK, WALK_START
from .swing_walk import SwingTables, Walk
from .trace import STATUS_LOST, STATUS_OK, STATUS_STUCK
from .trajectory import EARLIEST, Dynamics, LostTrajectoryError, Trajectory

__all__ = ["COARSE", "EXACT", "WIDEST_BAND", "Moments", "Workspace"]

EXACT = 9.5  # digits
COARSE = 5.5
WIDEST_BAND = 25.0  # nothing happens at small sizes: more half swings in one table cost no more sizes
_ROOM = 1.05  # that a table has for the parameters to change before it needs another number of sizes
_LOST = "no further turning point: the motion is not an oscillation"


def _check(d: Dynamics, end_s: float) -> None:
    """Raises LostTrajectoryError for what is no oscillation, or begins too late."""
    finite = math.isfinite(d.w * end_s + d.theta + sum(d.values))
    if not (finite and 0.0 < abs(d.amplitude) < np.pi and d.theta >= EARLIEST):
        raise LostTrajectoryError("the trajectory must pass a turning point within half a swing of t = 0")


class _Sums:
    """Moments of samples first .. last-1 of y, collected on a walk; every stride-th half swing takes part.

    clock: dt, w and theta of the motion.
    """

    def __init__(
        self, walk: Walk, clock: tuple[float, float, float], y: Array, window: tuple[int, int], observable: int,
        stride: int,
    ) -> None:  # fmt: skip
        self._walk, self._y, self._window, self._clock = walk, y, window, clock
        self._observable, self._stride, self._skipped = observable, stride, 0
        channels, b = y.shape[0], 7 + 2 * walk.columns
        self._sums = np.zeros((b, b)), np.zeros((channels, b)), np.zeros(channels)
        self.used = 0

    def collect(self, count: int, tables: SwingTables, symmetric: bool) -> None:
        """The samples of the half swings in the walk's last stretch."""
        if count:
            self.used += collect_swings(
                self._y, *self._window, *self._clock, self._skipped, self._stride, count, self._walk.heads,
                self._walk.weights, symmetric, self._observable, tables.grid.nodes, tables.grid.to_nodes,
                tables.values, *self._sums,
            )  # fmt: skip
        self._skipped += count

    def rest(self) -> None:
        """The remaining samples of a rotor that is stuck: dm/dt is silent, an angle is constant."""
        dt_s, w, theta = self._clock
        first, last = self._window
        at = self._walk.at
        y = self._y[:, max(first, math.ceil((at[WALK_START] - theta) / (w * dt_s))) : last]
        gram, products, energy = self._sums
        constant = self._walk.at_rest(self._observable)
        gram += y.shape[1] * np.outer(constant, constant)
        products += np.outer(y.sum(axis=1), constant)
        energy += np.sum(y**2, axis=1)
        self.used += y.shape[1]

    def moments(self) -> Moments:
        """What was collected."""
        return Moments(*self._sums, self.used, self._walk.at[WALK + self._walk.columns :])


@dataclass(frozen=True)
class _Held:
    """A walk that needed one stretch only: `count` half swings, as they stand in its heads and weights."""

    dynamics: Dynamics
    walk: Walk
    tables: SwingTables
    count: int


@dataclass
class Workspace:
    """Everything that passes over the same record with the same model can share."""

    model: RingDownModel
    _tables: dict[tuple[int, int], SwingTables] = field(default_factory=dict)
    _held: _Held | None = None

    def __post_init__(self) -> None:
        self.columns = 1 + len(self.model.coefficients)
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
        _check(d, last * dt_s)
        # The tables know half swings from their beginning on only, and nothing of time.
        direct_to = first if d.theta >= 0.0 else min(last, max(first, math.ceil(-d.theta / (d.w * dt_s))))
        if self.model.time_dependent or direct_to == last:
            return direct_moments(self.model, d, y, first, last, dt_s, observable)
        walk = Walk(self.model, d, d.w * (last - 1) * dt_s + d.theta)
        sums = _Sums(walk, (dt_s, d.w, d.theta), y, (direct_to, last), observable, stride)
        tables, ratio, band = self._fresh_tables(walk, digits, tabulated)
        self._held, counts = None, []
        for count in walk.stretches(tables, ratio, observable, digits, band):
            sums.collect(count, tables, self._symmetric)
            counts.append(count)
        if walk.status == STATUS_STUCK:
            sums.rest()
        if walk.status == STATUS_LOST or sums.used == 0:
            raise LostTrajectoryError(_LOST)
        if digits == EXACT and tabulated and sum(c > 0 for c in counts) == 1:
            self._held = _Held(d, walk, tables, max(counts))
        later = sums.moments()
        if direct_to == first:
            return later
        return direct_moments(self.model, d, y, first, direct_to, dt_s, observable).followed_by(later)

    def block_means(
        self, dynamics: Dynamics, begin: int, blocks: int, block: int, dt_s: float, observable: int, accuracy: float
    ) -> Array:
        """f1, f2 averaged over blocks of samples from sample `begin` on, (2, blocks); accuracy: relative.

        Goes the way that `moments` has gone, if it was called for this motion last.

        Raises:
            LostTrajectoryError: the parameters describe no oscillation.
        """
        d, out, done = dynamics, np.zeros((2, blocks)), 0
        places, shares = points_in(block, accuracy)
        for walk, tables, count in self._ways(d, d.w * (begin + blocks * block) * dt_s + d.theta, observable):
            used = tables.values[:1] if self._symmetric else tables.values
            done = fill_model(
                int(begin), int(block), places, shares, float(dt_s), float(d.w), float(d.theta), done, count,
                walk.heads, walk.weights, self._symmetric, to_coefficients(used, tables.grid.to_nodes, accuracy),
                1.0 if observable == DIPOLE else -1.0, out,
            )  # fmt: skip
        if walk.status == STATUS_STUCK and observable != DIPOLE:
            left = np.tile(shares, blocks)
            left[:done] = 0.0
            out[0] += walk.angle * left.reshape(blocks, -1).sum(axis=1)
        elif walk.status not in (STATUS_OK, STATUS_STUCK):
            raise LostTrajectoryError(_LOST)
        return out

    def basis(self, dynamics: Dynamics, first: int, last: int, dt_s: float, observable: int) -> Array:
        """Basis functions (sampling.py) at t = i dt_s, first <= i < last, float64 (n_basis, last - first).

        Like Trajectory.basis, but from the tables where these know the motion.

        Raises:
            LostTrajectoryError: the parameters describe no oscillation.
        """
        d = dynamics
        _check(d, last * dt_s)
        if self.model.time_dependent or d.w * first * dt_s + d.theta < 0.0:
            return Trajectory(self.model, d, last * dt_s).basis(first, last, dt_s, observable)
        out, done = np.zeros((7 + 2 * self.columns, last - first)), 0
        for walk, tables, count in self._ways(d, d.w * last * dt_s + d.theta, observable):
            done = fill_basis_from_table(
                int(first), float(dt_s), float(d.w), float(d.theta), done, count, walk.heads, walk.weights,
                self._symmetric, observable, tables.grid.nodes, tables.grid.to_nodes, tables.values, out,
            )  # fmt: skip
        if walk.status == STATUS_STUCK:
            out[:, done:] = walk.at_rest(observable)[:, None]
        elif walk.status != STATUS_OK:
            raise LostTrajectoryError(_LOST)
        return out

    def _ways(self, d: Dynamics, s_end: float, observable: int) -> Iterator[tuple[Walk, SwingTables, int]]:
        """Stretches of a walk until s_end, walked already or anew."""
        held = self._held
        if held is not None and held.dynamics == d and held.walk.reaches(s_end):
            yield held.walk, held.tables, held.count
            return
        walk = Walk(self.model, d, s_end)
        tables, ratio, band = self._fresh_tables(walk, EXACT, True)
        for count in walk.stretches(tables, ratio, observable, EXACT, band):
            yield walk, tables, count

    def _fresh_tables(
        self, walk: Walk, digits: float, tabulated: bool
    ) -> tuple[SwingTables, float, tuple[float, float]]:
        """Empty tables for a walk, how wide a band each of them covers, and the first of them: it sets the width."""
        size = abs(walk.angle)
        if not size < math.pi:
            raise LostTrajectoryError(_LOST)
        low, high = walk.band(WIDEST_BAND if tabulated else 1.0)
        ratio = min(WIDEST_BAND, _ROOM * high / low) if tabulated else 1.0
        key = nodes_for(size, digits), sizes_for(size, ratio, digits)
        if key not in self._tables:
            self._tables[key] = SwingTables(*key, self.columns)
        self._tables[key].bands.fill(0.0)
        return self._tables[key], ratio, (low, high)
