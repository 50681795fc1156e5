"""One shot as the fit of the rigid rotor takes it, and its linearisation in the free parameters."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.equations import LANES
from platform_daemon.estimation.physics.rigid_rotor.geometry import RotorGeometry
from platform_daemon.estimation.physics.rigid_rotor.motions import motions_beside
from platform_daemon.estimation.physics.rigid_rotor.rotor import (
    NO_DRIVE,
    CoilDrive,
    LostRotorError,
    RigidRotor,
    RotorValues,
)
from platform_daemon.estimation.physics.rotation import HALF_TURN_ABOUT_U
from platform_daemon.estimation.thresholds import THRESHOLDS

from .parameters import FreeParameter, Start

LIMITS = THRESHOLDS.rigid_rotor
MOMENT, SIZE, DELAY = "m_r_am2", "drive_size", "drive_delay_s"


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
    of white noise with the density that theirs has; values: start values; declared: (3, 3) orientation as the recording
    states it; start: in which state the motion begins, "free" with NO_DRIVE; noise_share: expected square of a sample's
    noise in units of sd^2, less than 1 where a filter has taken some of it.
    """

    samples: Array
    rate_hz: float
    sd: Array
    geometry: RotorGeometry
    drive: CoilDrive
    values: RotorValues
    declared: Array
    start: Start = "rest"
    noise_share: float = 1.0

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


def residuals(
    shots: Sequence[RotorShot], values: Sequence[RotorValues], window_s: float, pool: Executor
) -> list[Array]:
    """Whitened residual (3 n,) of each shot.

    Shots of one drive are computed beside each other, those of like length together, at time steps that are short
    enough for all of them: as many as there are lanes take little longer than one.

    Raises NoRestError, LostRotorError.
    """
    rotors = [shot.rotor(v) for shot, v in zip(shots, values, strict=True)]
    counts = [shot.count(window_s) for shot in shots]
    alike: dict[Hashable, list[int]] = {}
    for k in sorted(range(len(shots)), key=lambda k: counts[k]):  # so that none waits long for another one's end
        drive = replace(shots[k].drive, field_t=(0.0, 0.0, 0.0), rx_start_s=0.0)
        alike.setdefault((shots[k].geometry, drive, shots[k].rate_hz, rotors[k].sticks), []).append(k)
    groups = [places[k : k + LANES] for places in alike.values() for k in range(0, len(places), LANES)]
    motions = pool.map(
        lambda group: _together([rotors[k] for k in group], [counts[k] for k in group], shots[group[0]].rate_hz), groups
    )
    found = {}
    for group, some in zip(groups, motions, strict=True):
        for k, dm_dt in zip(group, some, strict=True):
            found[k] = shots[k].whitened(shots[k].samples[:, : counts[k]] - dm_dt)
    return [found[k] for k in range(len(shots))]


def _together(rotors: Sequence[RigidRotor], counts: Sequence[int], rate_hz: float) -> list[Array]:
    """dm/dt of each, (3, count).  Raises NoRestError, LostRotorError."""
    motions, ends = motions_beside(rotors, max(counts), rate_hz, counts=counts)
    last_s = max(
        r.drive.rx_start_s + r.values.drive_delay_s + (n - 1) / rate_hz for r, n in zip(rotors, counts, strict=True)
    )
    found = [motion for motion in motions if motion is not None]
    if ends.size == 0 or ends[-1] < last_s or len(found) < len(motions):
        raise LostRotorError("the rotor's motion cannot be followed")
    return found


@dataclass(frozen=True, eq=False)
class Linearised:
    """Normal equations of one shot at some values: J^T J, J^T r, r^T r, what that is of noise alone, J^T and r.

    columns: (free, residuals) float32: its rounding moves a minimum by 1e-4 of a standard error.
    """

    matrix: Array
    gradient: Array
    chi2: float
    expected: float
    columns: Array
    residual: Array


def linearised(
    shot: RotorShot, values: RotorValues, free: Sequence[FreeParameter], window_s: float, pool: Executor
) -> Linearised:
    """By forward differences at the steps of the motion itself, m_r by the column of the field's size.

    Raises NoRestError, LostRotorError.
    """
    (found,) = all_linearised([shot], [values], [free], window_s, pool)
    return found


def all_linearised(
    shots: Sequence[RotorShot],
    values: Sequence[RotorValues],
    free: Sequence[Sequence[FreeParameter]],
    window_s: float,
    pool: Executor,
) -> Iterator[Linearised]:
    """Of each shot, one after the other, while the pool is busy with those of its batch.

    A motion that chooses its steps leaves lanes for the first columns; the others follow at its steps.  The columns of
    a long shot take a hundred megabytes before they are put together, so that batches are small.

    Raises NoRestError, LostRotorError.
    """
    rows = list(zip(shots, values, free, strict=True))
    for k in range(0, len(rows), LIMITS.shots_at_once):
        yield from _batch(rows[k : k + LIMITS.shots_at_once], window_s, pool)


def _batch(
    rows: Sequence[tuple[RotorShot, RotorValues, Sequence[FreeParameter]]], window_s: float, pool: Executor
) -> Iterator[Linearised]:
    """Of some shots, all beside each other.  Raises NoRestError, LostRotorError."""
    moved = [_with_own_motion(shot, free) for shot, _, free in rows]
    begun = [pool.submit(_motion, *row[:2], own, row[2], window_s) for row, own in zip(rows, moved, strict=True)]
    motions, waiting = [], []
    for (shot, v, _), own in zip(rows, moved, strict=True):
        motions.append(begun.pop(0).result())
        groups = [own[j : j + LANES] for j in range(LANES - 1, len(own), LANES)]
        waiting.append([pool.submit(_columns, shot, v, group, motions[-1]) for group in groups])
    for shot, v, free in rows:
        yield _put_together(shot, v, free, motions.pop(0), waiting.pop(0))


def _put_together(
    shot: RotorShot,
    values: RotorValues,
    free: Sequence[FreeParameter],
    motion: _Motion,
    others: Sequence[Future[dict[str, Array]]],
) -> Linearised:
    """others: columns beside those of the motion.  Raises LostRotorError."""
    found = dict(motion.columns)
    for group in others:
        found |= group.result()
    columns = np.array([found[p.name] if p.name in found else _of_moment(shot, values, motion, found) for p in free])
    residual = shot.whitened(shot.samples[:, : motion.samples.shape[1]] - motion.samples)
    return Linearised(
        columns @ columns.T,
        columns @ residual,
        float(residual @ residual),
        shot.noise_share * residual.size,
        columns.astype(np.float32),
        residual,
    )


@dataclass(frozen=True, eq=False)
class _Motion:
    """dm/dt, (3, n), the first columns of the Jacobian by name, and the ends of the steps."""

    samples: Array
    columns: dict[str, Array]
    steps: Array


def _with_own_motion(shot: RotorShot, free: Sequence[FreeParameter]) -> list[FreeParameter]:
    """Not the delay, and m_r only if there is a drive whose size is held.

    The stator's moment follows from f_nat, so that m_r turns the rotor by the drive alone: dm/dt is m_r times a motion
    that depends on m_r times the field.
    """
    by_size = shot.start == "free" or any(p.name == SIZE for p in free)
    return [p for p in free if p.name != DELAY and not (p.name == MOMENT and by_size)]


def _of_moment(shot: RotorShot, values: RotorValues, motion: _Motion, found: Mapping[str, Array]) -> Array:
    """The column of m_r by that of the field's size."""
    own = shot.whitened(motion.samples / values.m_r_am2)
    if SIZE not in found:
        return own
    return np.asarray(own + values.drive_size / values.m_r_am2 * found[SIZE])


def _motion(
    shot: RotorShot, values: RotorValues, moved: Sequence[FreeParameter], free: Sequence[FreeParameter], window_s: float
) -> _Motion:
    """Raises NoRestError, LostRotorError."""
    n, beside = shot.count(window_s), [*moved[: LANES - 1], *(p for p in free if p.name == DELAY)]
    late_s = [p.step for p in beside if p.name == DELAY]
    neighbours = _neighbours(shot, values, moved[: LANES - 1])
    samples, others, steps = shot.rotor(values).dm_dt_beside(neighbours, n, shot.rate_hz, late_s=late_s)
    return _Motion(samples, _differences(shot, samples, others, beside), steps)


def _columns(shot: RotorShot, values: RotorValues, free: Sequence[FreeParameter], motion: _Motion) -> dict[str, Array]:
    """Raises NoRestError, LostRotorError."""
    n = motion.samples.shape[1]
    near = shot.rotor(values)
    others, _ = motions_beside(_neighbours(shot, values, free), n, shot.rate_hz, motion.steps, near=near)
    return _differences(shot, motion.samples, others, free)


def _neighbours(shot: RotorShot, values: RotorValues, free: Sequence[FreeParameter]) -> list[RigidRotor]:
    """Rotors of which one parameter is moved by its step."""
    return [shot.rotor(values.with_numbers({p.name: p.moved(getattr(values, p.name), p.step)})) for p in free]


def _differences(
    shot: RotorShot, samples: Array, others: Sequence[Array | None], free: Sequence[FreeParameter]
) -> dict[str, Array]:
    """Whitened, per unit of each parameter, by its name.  Raises LostRotorError."""
    found = {}
    for other, p in zip(others, free, strict=True):
        if other is None:
            raise LostRotorError("the motion of a neighbour cannot be followed")
        found[p.name] = shot.whitened((other - samples) / p.step)
    return found
