"""Measurements that would part manufacturing errors which act alike, from the motions of both rotors alone.

The rotor with the named error stands for what would be measured.  The rotor with its rival is fitted to that to first
order: its own parameters freely, the common ones as far as the present shots know them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.diagnosis.rigid_body.found_error import ManufacturingError
from platform_daemon.diagnosis.shots.thread_pool import beside_each_other
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.rotor import LostRotorError, NoRestError
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.rotor_fit.fit import RotorFit
from platform_daemon.estimation.rotor_fit.parameters import free_parameters
from platform_daemon.estimation.rotor_fit.shot import RotorShot, linearised
from platform_daemon.estimation.rotor_fit.valley import limited_step

from .next_measurements import MEASUREMENTS, Proposal

_LIMITS = THRESHOLDS.findings
_ON_ITS_SIDE = rotation_from_rodrigues(np.array([0.5 * np.pi, 0.0, 0.0]))  # the main axis from z to -y


def _driven(factor: float) -> Callable[[RotorShot], RotorShot]:
    def planned(shot: RotorShot) -> RotorShot:
        if shot.start == "free":
            begun = {name: factor * value for name, value in shot.values.start.items()}
            return replace(shot, values=shot.values.with_numbers(begun))
        x, y, z = shot.drive.field_t
        return replace(shot, drive=replace(shot.drive, field_t=(factor * x, factor * y, factor * z)))

    return planned


def _twice_as_long(shot: RotorShot) -> RotorShot:
    return replace(shot, samples=np.zeros((3, 2 * shot.samples.shape[1])))


def _turned(shot: RotorShot) -> RotorShot:
    return replace(shot, values=replace(shot.values, rotation=_ON_ITS_SIDE @ shot.values.rotation))


# By the measurement's key.
PLANS: dict[str, Callable[[RotorShot], RotorShot]] = {
    "second_amplitude": _driven(0.5),
    "twice_the_field": _driven(2.0),
    "longer_window": _twice_as_long,
    "on_its_side": _turned,
}


def parting(rotor: ManufacturingError, pool: Executor) -> tuple[Proposal, ...]:
    """Measurements that would part the named error from those that act alike, the largest expected difference first.

    A plan that the rotor cannot follow is left out, a look-alike that cannot is left out of it.  Empty where nothing
    acts alike.
    """
    if not rotor.alike:
        return ()
    count, present = len(rotor.fit.shots), [max(0.0, a.rise) for a in rotor.alike]
    # By the measurement's key: expected standard deviations by the place of the look-alike.
    ways = {"more_shots": {k: math.sqrt((1.0 + _LIMITS.more_shots_ratio) * rise) for k, rise in enumerate(present)}}

    def further(key: str) -> list[float | None]:
        found: list[float | None] = []
        for a in rotor.alike:
            try:
                found.append(count * _difference(PLANS[key], rotor.fit, a.fit, pool))
            except (NoRestError, LostRotorError, np.linalg.LinAlgError):
                found.append(None)
        return found

    for key, found in zip(PLANS, beside_each_other(further, PLANS), strict=True):
        expected = {k: math.sqrt(present[k] + later) for k, later in enumerate(found) if later is not None}
        if expected:
            ways[key] = expected
    proposals = []
    for key, expected in ways.items():
        most = max(expected, key=lambda k: expected[k])
        apart = [k for k, sigma in expected.items() if sigma >= _LIMITS.apart_sigma] or [most]
        ids = tuple(dict.fromkeys((rotor.effect.id, *(rotor.alike[k].effect.id for k in apart))))
        proposals.append(Proposal(MEASUREMENTS[key], ids, min(expected[k] for k in apart)))
    return tuple(sorted(proposals, key=lambda p: -p.expected_sigma))


def _difference(plan: Callable[[RotorShot], RotorShot], best: RotorFit, rival: RotorFit, pool: Executor) -> float:
    """chi^2 that the rival leaves of one planned shot like the first one, if it may move as far as the shots let it.

    Raises NoRestError, LostRotorError, LinAlgError.
    """
    planned = plan(replace(best.shots[0], values=best.values[0]))
    truth, _ = planned.rotor(planned.values).dm_dt(planned.samples.shape[1], planned.rate_hz)
    other = plan(replace(rival.shots[0], values=rival.values[0]))
    shot = replace(other, samples=truth)
    assert rival.defect is not None
    free = free_parameters(shot.geometry, [rival.defect], shot.start)
    known = _known(rival, [p.name for p in free if p.common], [p.name for p in free])
    known += np.diag([0.0 if p.sd is None or p.common else p.sd**-2 for p in free])
    most = np.array([p.most_step for p in free])
    values, gone = shot.values, np.zeros(len(free))
    left = before = math.inf
    for _ in range(_LIMITS.planned_steps):
        seen = linearised(shot, values, free, math.inf, pool)
        here = seen.chi2 + float(gone @ known @ gone)
        if here > before:  # this far the first order tells nothing
            break
        gradient = seen.gradient - known @ gone
        matrix = seen.matrix + known
        step = limited_step(matrix, gradient, most)
        promised = max(0.0, here - float(2.0 * gradient @ step - step @ matrix @ step))
        # A promise holds near the least chi^2: where less than noise is left, or where a step has led down and the next
        # one would bring little, not because it is at a bound.
        ends = promised > _LIMITS.promised_share * here and bool(np.all(np.abs(step) < most))
        if here < seen.expected or (math.isfinite(before) and ends):
            left = min(left, promised)
        if left < THRESHOLDS.rigid_body.worth_sigma**2:  # it will not be proposed
            break
        before = here
        values = values.with_numbers(
            {p.name: p.moved(getattr(values, p.name), d) for p, d in zip(free, step, strict=True)}
        )
        gone += step
    if math.isinf(left):
        raise LostRotorError("the rotor with the rival cannot be followed from the present shots to the planned one")
    return left


def _known(fit: RotorFit, common: Sequence[str], names: Sequence[str]) -> Array:
    """What the present shots know of the common parameters, whatever the others are: (names, names)."""
    places = [fit.places[0][name] for name in common]
    here = [names.index(name) for name in common]
    out = np.zeros((len(names), len(names)))
    out[np.ix_(here, here)] = np.linalg.inv(fit.covariance[np.ix_(places, places)])
    return out
