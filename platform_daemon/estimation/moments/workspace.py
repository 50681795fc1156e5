"""Moments of a window with a trajectory: picks the grids, and keeps tables between the passes of a fit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.chebyshev import EXACT, nodes_for
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.basis_functions import DIPOLE
from platform_daemon.estimation.physics.trajectory.direct import (
    EARLIEST,
    LostTrajectoryError,
    MotionParameters,
    Trajectory,
)
from platform_daemon.estimation.physics.trajectory.direct_chain import STATUS_LOST, STATUS_OK, STATUS_STUCK
from platform_daemon.estimation.physics.trajectory.half_cycle_walk import HalfCycleTables, HalfCycleWalk
from platform_daemon.estimation.physics.trajectory.table_range import WALK, WALK_START

from .basis import fill_basis_from_table
from .direct import Moments, direct_moments
from .model_signal import fill_model, quadrature_points, to_coefficients
from .tabulated import collect_half_cycles

__all__ = ["Moments", "Workspace"]

_LOST = "no further turning point: the motion is not an oscillation"


def _check(d: MotionParameters, end_s: float) -> None:
    """Raises LostTrajectoryError for what is no oscillation, or begins too late."""
    finite = math.isfinite(d.w * end_s + d.theta + sum(d.values))
    if not (finite and 0.0 < abs(d.amplitude) < np.pi and d.theta >= EARLIEST):
        raise LostTrajectoryError("the trajectory must pass a turning point within half a cycle of t = 0")


@dataclass(frozen=True)
class _Held:
    """A walk that needed one stretch only: `count` half cycles, as they are in its heads and weights."""

    dynamics: MotionParameters
    walk: HalfCycleWalk
    tables: HalfCycleTables
    count: int


@dataclass
class Workspace:
    """Everything that passes over the same record with the same model can share."""

    model: RingDownModel
    _tables: dict[int, HalfCycleTables] = field(default_factory=dict)
    _held: _Held | None = None

    def __post_init__(self) -> None:
        self.columns = 1 + len(self.model.coefficients)
        self._basis_size = 7 + 2 * self.columns
        self._symmetric = self.model.symmetric

    def moments(
        self, dynamics: MotionParameters, y: Array, first: int, last: int, dt_s: float, observable: int,
        stride: int = 1, digits: float = EXACT,
    ) -> Moments:  # fmt: skip
        """Moments of samples first .. last-1 of y (channels, n), or of every stride-th (odd) half cycle of them.

        digits: to how many the trajectory is represented.
        Torques that depend on time take the direct path, which knows neither stride nor digits.

        Raises:
            LostTrajectoryError: the parameters describe no oscillation.
        """
        d = dynamics
        _check(d, last * dt_s)
        # The tables know half cycles from their beginning on only, and nothing of time.
        direct_to = first if d.theta >= 0.0 else min(last, max(first, math.ceil(-d.theta / (d.w * dt_s))))
        if self.model.time_dependent or direct_to == last:
            return direct_moments(self.model, d, y, first, last, dt_s, observable)
        later = self._collected(d, y, direct_to, last, dt_s, observable, stride, digits)
        if direct_to == first:
            return later
        return direct_moments(self.model, d, y, first, direct_to, dt_s, observable).followed_by(later)

    def _collected(
        self,
        d: MotionParameters,
        y: Array,
        first: int,
        last: int,
        dt_s: float,
        observable: int,
        stride: int,
        digits: float,
    ) -> Moments:
        """The same by a walk, from its anchor on; keeps it if it is exact and needed one stretch only."""
        walk, tables = HalfCycleWalk(self.model, d, d.w * (last - 1) * dt_s + d.theta), self._tables_for(d, digits)
        b, channels, g = self._basis_size, y.shape[0], tables.grid
        sums = np.zeros((b, b)), np.zeros((channels, b)), np.zeros(channels)
        self._held = None
        used = passed = stretches = 0
        for count in walk.stretches(tables, observable, digits):
            if count:
                stretches += 1
                used += collect_half_cycles(
                    y, first, last, dt_s, d.w, d.theta, passed, stride, count, walk.heads, walk.weights,
                    self._symmetric, observable, g.nodes, g.to_nodes, tables.values, *sums,
                )  # fmt: skip
                passed += count
        if walk.status == STATUS_STUCK:
            begin = max(first, math.ceil((walk.at[WALK_START] - d.theta) / (d.w * dt_s)))
            used += _add_rest(y[:, begin:last], walk.at_rest(observable), *sums)
        if walk.status == STATUS_LOST or used == 0:
            raise LostTrajectoryError(_LOST)
        if digits == EXACT and stretches == 1:
            self._held = _Held(d, walk, tables, passed)
        gram, products, energy = sums
        return Moments(gram=gram, products=products, energy=energy, samples=used, slopes=walk.at[WALK + self.columns :])

    def block_means(
        self,
        dynamics: MotionParameters,
        *,
        begin: int,
        blocks: int,
        block: int,
        dt_s: float,
        observable: int,
        accuracy: float,
    ) -> Array:
        """f1, f2 averaged over blocks of samples from sample `begin` on, (2, blocks); accuracy: relative.

        Uses the walk of `moments`, if that was called for this motion last.

        Raises:
            LostTrajectoryError: the parameters describe no oscillation.
        """
        d = dynamics
        out = np.zeros((2, blocks))
        done = 0
        places, shares = quadrature_points(block, accuracy)
        for walk, tables, count in self._ways(d, d.w * (begin + blocks * block) * dt_s + d.theta, observable):
            used = tables.values[: 1 if self._symmetric else 2, : walk.weights.shape[1]]
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

    def basis(self, dynamics: MotionParameters, first: int, last: int, dt_s: float, observable: int) -> Array:
        """Basis functions (basis_functions.py) at t = i dt_s, first <= i < last, float64 (n_basis, last - first).

        Like Trajectory.basis, but from the tables where these know the motion.

        Raises:
            LostTrajectoryError: the parameters describe no oscillation.
        """
        d = dynamics
        _check(d, last * dt_s)
        if self.model.time_dependent:
            return Trajectory(self.model, d, last * dt_s).basis(first, last, dt_s, observable)
        if d.w * first * dt_s + d.theta < 0.0:
            # Tables begin at the anchor; what lies before it is a part of one half cycle.
            anchored = min(last, max(first + 1, math.ceil(-d.theta / (d.w * dt_s))))
            head = Trajectory(self.model, d, anchored * dt_s).basis(first, anchored, dt_s, observable)
            if anchored == last:
                return head
            return np.concatenate([head, self.basis(d, anchored, last, dt_s, observable)], axis=1)
        out, done = np.zeros((self._basis_size, last - first)), 0
        for walk, tables, count in self._ways(d, d.w * last * dt_s + d.theta, observable):
            done = fill_basis_from_table(
                int(first), float(dt_s), float(d.w), float(d.theta), done, count, walk.heads, walk.weights,
                self._symmetric, observable, tables.grid.nodes, tables.values, out,
            )  # fmt: skip
        if walk.status == STATUS_STUCK:
            out[:, done:] = walk.at_rest(observable)[:, None]
        elif walk.status != STATUS_OK:
            raise LostTrajectoryError(_LOST)
        return out

    def _ways(
        self, d: MotionParameters, s_end: float, observable: int
    ) -> Iterator[tuple[HalfCycleWalk, HalfCycleTables, int]]:
        """Stretches of a walk until s_end: of the kept walk if it is the same motion, else of a new one."""
        held = self._held
        if held is not None and held.dynamics == d and held.walk.reaches(s_end):
            yield held.walk, held.tables, held.count
            return
        self._held = None  # its tables are written over
        walk, tables = HalfCycleWalk(self.model, d, s_end), self._tables_for(d, EXACT)
        for count in walk.stretches(tables, observable, EXACT):
            yield walk, tables, count

    def _tables_for(self, d: MotionParameters, digits: float) -> HalfCycleTables:
        """Room for tables that represent half cycles from this amplitude on to so many digits."""
        nodes = nodes_for(abs(d.amplitude), digits)
        if nodes not in self._tables:
            self._tables[nodes] = HalfCycleTables(nodes, self.columns)
        return self._tables[nodes]


def _add_rest(y: Array, constant: Array, gram: Array, products: Array, energy: Array) -> int:
    """Add samples y (channels, n) of a rotor that is stuck, whose basis is constant (b,); returns n."""
    gram += y.shape[1] * np.outer(constant, constant)
    products += np.outer(y.sum(axis=1), constant)
    energy += np.sum(y**2, axis=1)
    return y.shape[1]
