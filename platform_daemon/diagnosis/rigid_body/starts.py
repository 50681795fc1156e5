"""Where fits of a rotor with a manufacturing error begin."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.rotor import RotorValues
from platform_daemon.estimation.physics.rotation import rodrigues_from_rotation
from platform_daemon.estimation.rotor_fit.fit import Stage
from platform_daemon.estimation.rotor_fit.parameters import DEFECTS, Defect
from platform_daemon.estimation.rotor_fit.shot import RotorShot

from .free_start import begun_freely, left_over, settled_start

_LIMITS = THRESHOLDS.rigid_body


@dataclass(frozen=True)
class Start:
    """Values with an error, what is known beforehand, and the windows that led to them."""

    defect: Defect
    values: RotorValues
    known: RotorValues
    stages: tuple[Stage, ...] = ()


def starts_of(shot: RotorShot, pool: Executor) -> Iterator[list[Start]]:
    """Of a short window, and others if none of these finds a rotor.

    With a large error one angle takes the part along the main axis for an orientation, and is wrong about m_r with it.
    Where its orientation is far from the declared one, or leads nowhere and no drive is known, a grid at the declared
    one tells where to begin.
    """
    apart = np.linalg.norm(rodrigues_from_rotation(shot.values.rotation.T @ shot.declared))
    if apart < _LIMITS.near_rad:
        yield _near(shot)
        if shot.start != "free":
            return
    yield _of_grid(shot, pool)


def _near(shot: RotorShot) -> list[Start]:
    """A thread's errors act differently when they are large; those of a jewel act alike in so short a time.  Both signs
    are tried."""
    values, tilt = shot.values, _LIMITS.start_rad
    if shot.geometry.bearing == "jewel":
        return [_jewel_start(shot, sign) for sign in (1.0, -1.0)]
    sizes = {d: _LIMITS.start_m if d == "lateral_displacement_m" else tilt for d in DEFECTS}
    return [
        Start(d, values.with_numbers({d: sign * size}), values) for d, size in sizes.items() for sign in (1.0, -1.0)
    ]


def _jewel_start(shot: RotorShot, sign: float) -> Start:
    """A small or a large tilt, by what they leave: f_nat is above the main mode by the square of the tilt, so that the
    phase of a small one runs away from that of a large one within the window."""
    values, starts = shot.values, []
    for tilt in (_LIMITS.start_rad, _LIMITS.large_start_rad):
        f_nat_hz = (1.0 + _LIMITS.jewel_softening * tilt**2) * values.f_nat_hz
        tilted = values.with_numbers({DEFECTS[0]: sign * tilt, "f_nat_hz": f_nat_hz})
        starts.append(Start(DEFECTS[0], tilted, values))
    return min(starts, key=lambda start: left_over(shot, start.values))


def _of_grid(shot: RotorShot, pool: Executor) -> list[Start]:
    """The best points for each kind of a grid over its size, m_r, and f_nat above the main mode by its square.

    By the drawing rotor and stator are the same magnet, of which real ones fall short.
    """
    points = list(_grid(shot))
    if shot.start == "free":
        likely = _best(shot, points, _LIMITS.grid_settled, pool)
        points = [replace(one, values=settled_start(shot, one.values, pool)) for one in likely]
    return _best(shot, points, _LIMITS.grid_kept, pool)


def _best(shot: RotorShot, points: Sequence[Start], count: int, pool: Executor) -> list[Start]:
    """Of each kind of error so many that leave least."""
    left = np.array(list(pool.map(lambda p: left_over(shot, p.values), points)))
    found = []
    for defect in DEFECTS:
        places = [k for k in np.argsort(left) if points[k].defect == defect and math.isfinite(left[k])]
        found += [points[k] for k in places[:count]]
    return found


def _grid(shot: RotorShot) -> Iterator[Start]:
    main_hz = shot.values.f_nat_hz
    begun = {share: _begun(shot, share * shot.geometry.stator_moment_am2) for share in _LIMITS.grid_moments}
    for defect, sign in itertools.product(DEFECTS, (1.0, -1.0)):
        largest = _LIMITS.largest_m if defect == "lateral_displacement_m" else _LIMITS.largest_rad
        for part, above, share, side_damping_per_s in itertools.product(
            np.arange(1, _LIMITS.grid_sizes + 1) / _LIMITS.grid_sizes,
            _LIMITS.grid_softening,
            _LIMITS.grid_moments,
            _LIMITS.grid_side_damping_per_s,
        ):
            f_nat_hz = main_hz * (1.0 + above * (part * _LIMITS.largest_rad) ** 2)
            known = replace(
                begun[share],
                f_nat_hz=f_nat_hz,
                distance_m=shot.geometry.distance_m(f_nat_hz, begun[share].m_r_am2),
                side_damping_per_s=side_damping_per_s,
                lean_damping_per_s=side_damping_per_s,
            )
            yield Start(defect, known.with_numbers({defect: float(sign * part * largest)}), known)


def _begun(shot: RotorShot, m_r_am2: float) -> RotorValues:
    """At the declared orientation, without an error."""
    values = replace(shot.values, rotation=shot.declared, m_r_am2=m_r_am2)
    return begun_freely(shot, values) if shot.start == "free" else values
