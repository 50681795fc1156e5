"""What the errors of parameters that an adopted model holds make of those that a fit of its rotor finds."""

from __future__ import annotations

from concurrent.futures import Executor
from typing import TYPE_CHECKING

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.rotor import LostRotorError, NoRestError, RigidRotor
from platform_daemon.estimation.rotor_fit.parameters import DEFECTS, free_parameters
from platform_daemon.estimation.rotor_fit.shot import RotorShot, linearised
from platform_daemon.estimation.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from .creation import TableBasis

LIMITS = THRESHOLDS.rotor_correction


def covariance_of_held(basis: TableBasis, names: tuple[str, ...], pool: Executor) -> Array:
    """Of `names`, (names, names): as in fits with the adopted model (`with_errors_of_held`), at the reference.

    Zeros where nothing is known of what is held.
    """
    if basis.held_covariance is None or not basis.held_names:
        return np.zeros((len(names), len(names)))
    dm_dt, _ = RigidRotor(basis.geometry, basis.reference, basis.drive).dm_dt(basis.samples, basis.rate_hz)
    rms = float(np.sqrt(np.mean(dm_dt**2)))
    shot = RotorShot(
        samples=dm_dt,
        rate_hz=basis.rate_hz,
        sd=np.full(3, LIMITS.noise_share * rms),
        geometry=basis.geometry,
        drive=basis.drive,
        values=basis.reference,
        declared=basis.reference.rotation,
    )
    known = {p.name: p for p in free_parameters(basis.geometry, DEFECTS, "rest")}
    held = [known[name] for name in basis.held_names]
    free = [p for p in known.values() if not p.common or p.name == "lambda_per_s"]
    window_s = basis.window_s or basis.samples / basis.rate_hz
    try:
        found = linearised(shot, basis.reference, [*free, *held], window_s, pool)
    except (NoRestError, LostRotorError):
        return np.zeros((len(names), len(names)))
    size = len(free)
    prior = np.diag([0.0 if p.sd is None else p.sd**-2 for p in free])
    follow = np.linalg.solve(found.matrix[:size, :size] + prior, found.matrix[:size, size:])
    scale = np.array([p.per_step(getattr(basis.reference, p.name)) for p in held])
    spread = follow @ (basis.held_covariance / np.outer(scale, scale)) @ follow.T
    rows = [[p.name for p in free].index(name) for name in names]
    return np.asarray(spread[np.ix_(rows, rows)])
