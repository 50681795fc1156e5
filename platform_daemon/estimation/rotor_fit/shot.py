"""One shot as the fit of the rigid rotor takes it, and its linearisation in the free parameters."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.equations import LANES
from platform_daemon.estimation.physics.rigid_rotor.motions import motions_beside
from platform_daemon.estimation.physics.rigid_rotor.rotor import (
    NO_DRIVE,
    CoilDrive,
    LostRotorError,
    RigidRotor,
    RotorGeometry,
    RotorValues,
)
from platform_daemon.estimation.physics.rotation import HALF_TURN_ABOUT_U

from .parameters import FreeParameter, Start


@dataclass(frozen=True, eq=False, kw_only=True)
class RotorContext:
    """What is known of a shot's rotor before any fit.

    drive: None if nothing is known of it; rotation: (3, 3) as declared, from u, v, w to world axes, None if it is not;
    swinging: a swing of the shot before may be left when the drive begins; assumed: what is taken for known, in words.
    """

    geometry: RotorGeometry
    drive: CoilDrive | None
    rotation: Array | None
    swinging: bool = False
    assumed: tuple[str, ...] = ()

    @property
    def start(self) -> Start:
        """In which state a motion begins."""
        if self.drive is None:
            return "free"
        return "swing" if self.swinging else "rest"

    def drive_from(self, late_s: float) -> CoilDrive:
        """The drive of samples that begin so long after the first one of RX."""
        if self.drive is None:
            return NO_DRIVE
        return replace(self.drive, rx_start_s=self.drive.rx_start_s + late_s)

    def turned(self, rotation: Array) -> bool:
        """Of an orientation and its mirror solution, which one angle cannot tell apart, w is as declared in the other
        one; with none declared the rotor hangs or lies above its stator, or beside it."""
        along = rotation[2, 2] if self.rotation is None else (self.rotation.T @ rotation)[2, 2]
        return bool(along < 0.0)

    def facing(self, rotation: Array) -> Array:
        """The one of these two."""
        return rotation @ HALF_TURN_ABOUT_U if self.turned(rotation) else rotation


@dataclass(frozen=True, eq=False, kw_only=True)
class RotorShot:
    """A ring-down after a known drive, or from a free start.

    samples: dm/dt, (3, n) A m^2/s, world axes, the first one `drive.rx_start_s` after the start of the drive; sd: (3,)
    of white noise; values: start values; declared: (3, 3) orientation as the recording states it; start: in which state
    the motion begins, "free" with NO_DRIVE.
    """

    samples: Array
    rate_hz: float
    sd: Array
    geometry: RotorGeometry
    drive: CoilDrive
    values: RotorValues
    declared: Array
    start: Start = "rest"

    def count(self, window_s: float) -> int:
        """Samples in a window from the first one."""
        return max(1, round(min(self.samples.shape[1], window_s * self.rate_hz)))

    def rotor(self, values: RotorValues) -> RigidRotor:
        """Its rotor with these values."""
        return RigidRotor(self.geometry, values, self.drive)

    def whitened(self, dm_dt: Array) -> Array:
        """(3, n) in standard deviations and without its mean in every channel, as a vector (3 n,)."""
        scaled = dm_dt / self.sd[:, None]
        return np.asarray((scaled - scaled.mean(axis=1, keepdims=True)).ravel())

    def residual(self, values: RotorValues, window_s: float) -> Array:
        """Whitened residual (3 n,).  Raises NoRestError, LostRotorError."""
        n = self.count(window_s)
        return self.whitened(self.samples[:, :n] - self.rotor(values).dm_dt(n, self.rate_hz)[0])


@dataclass(frozen=True, eq=False)
class Linearised:
    """Normal equations of one shot at some values: J^T J, J^T r, r^T r, the number of residuals, J^T and r.

    columns: (free, residuals) float32: its rounding moves a minimum by 1e-4 of a standard error.
    """

    matrix: Array
    gradient: Array
    chi2: float
    count: int
    columns: Array
    residual: Array


def linearised(
    shot: RotorShot, values: RotorValues, free: Sequence[FreeParameter], window_s: float, pool: Executor
) -> Linearised:
    """By forward differences at the steps of the motion itself.  Raises NoRestError, LostRotorError."""
    n = shot.count(window_s)
    model, steps = shot.rotor(values).dm_dt(n, shot.rate_hz)
    residual = shot.whitened(shot.samples[:, :n] - model)

    def columns_of(some: Sequence[FreeParameter]) -> list[Array]:
        moved = [values.with_numbers({p.name: p.moved(getattr(values, p.name), p.step)}) for p in some]
        others, _ = motions_beside([shot.rotor(each) for each in moved], n, shot.rate_hz, steps)
        return [shot.whitened((_found(other) - model) / p.step) for other, p in zip(others, some, strict=True)]

    groups = [free[k : k + LANES] for k in range(0, len(free), LANES)]
    columns = np.array([column for group in pool.map(columns_of, groups) for column in group])
    return Linearised(
        columns @ columns.T,
        columns @ residual,
        float(residual @ residual),
        residual.size,
        columns.astype(np.float32),
        residual,
    )


def _found(dm_dt: Array | None) -> Array:
    if dm_dt is None:
        raise LostRotorError("the motion of a neighbour cannot be followed")
    return dm_dt
