"""The search for a rotor of five degrees of freedom, before that for effects of one angle or beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.thresholds import THRESHOLDS as FIT_THRESHOLDS

from .findings.rotor_findings import chi2_beside_one_angle, few_jewels, leaves_noise
from .regression.hypothesis import Hypothesis
from .regression.joint_fit import JointFit, fit_jointly
from .rigid_body.defects import manufacturing_error
from .rigid_body.found_error import ManufacturingError
from .rigid_body.plane_test import PlaneTest
from .shots.shot import PreparedShot
from .shots.thread_pool import StoppableExecutor
from .thresholds import THRESHOLDS

_LIMITS = THRESHOLDS.rigid_body
_FIT_LIMITS = FIT_THRESHOLDS.rigid_rotor


def rotor_of(
    prepared: Sequence[PreparedShot], model: RingDownModel, plane: PlaneTest, pool: Executor
) -> tuple[JointFit, ManufacturingError] | None:
    """The declared model's fit, and the manufacturing error that explains what it cannot; None if none does."""
    if any(s.shot.rotor is None for s in prepared):
        return None
    try:
        declared = fit_jointly(_largest_first(prepared, plane), Hypothesis(model), pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None
    if not plane.leaves and declared.leaves_noise:
        return None
    rotor = manufacturing_error(declared, pool, leaving_noise=not plane.leaves)
    driven = any(s.shot.rotor is not None and s.shot.rotor.drive is not None for s in prepared)
    if driven and plane.leaves and (rotor is None or _drive_is_doubtful(rotor)):
        freed = replace(declared, prepared=tuple(map(_without_drive, declared.prepared)))
        free = manufacturing_error(freed, pool)
        if free is not None and (rotor is None or _leaves_less(free, freed, rotor, declared)):
            declared, rotor = freed, free
    return None if rotor is None or not (plane.leaves or leaves_noise(rotor)) else (declared, rotor)


def _largest_first(prepared: Sequence[PreparedShot], plane: PlaneTest) -> list[PreparedShot]:
    """The shots, one that swings much more than the first before it: the others begin with what the first one found in
    common, of which a small swing tells too little.

    Where the swing of one shot may be left at the start of the next one, they stay in the order of time.
    """
    swing = [one.swing_rad for one in plane.shots]
    most = int(np.argmax(swing))
    swinging = any(s.shot.rotor is not None and s.shot.rotor.swinging for s in prepared)
    if swinging or swing[most] < _LIMITS.leading_swing * swing[0]:
        return list(prepared)
    return [prepared[most], *prepared[:most], *prepared[most + 1 :]]


class RotorBeside:
    """The search for a rotor that leaves only noise, beside that for effects of one angle, until it is of no use.

    For motions that stay in their plane as far as the noise shows, of which no rotor was sought before.
    """

    def __init__(self, plane: PlaneTest | None, pool: Executor) -> None:
        self._plane, self._pool = plane, pool
        self._beside, self._thread = StoppableExecutor(pool), ThreadPoolExecutor(1, thread_name_prefix="rotor")
        self._begun: tuple[JointFit, Future[ManufacturingError | None]] | None = None

    def __enter__(self) -> RotorBeside:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._beside.stop()
        self._thread.shutdown(wait=kind is None, cancel_futures=True)

    def untried(self, base: JointFit) -> PlaneTest | None:
        """The test of the plane, where no rotor was sought beforehand that one angle with this fit could need."""
        plane = self._plane
        if plane is None or plane.leaves or (plane.may_leave and not base.leaves_noise):
            return None
        return plane

    def begin(self, base: JointFit) -> None:
        """The search begins beside the present one, if it may be needed."""
        if self._begun is None and self.untried(base) is not None and not base.leaves_noise and few_jewels(base):
            self._begun = base, self._thread.submit(manufacturing_error, base, self._beside, leaving_noise=True)

    def of(self, base: JointFit) -> ManufacturingError | None:
        """Its result."""
        if self._begun is None or self._begun[0] is not base:
            self._beside.stop()
            if self._begun is not None:
                self._begun[1].exception()  # wait, so that no two searches keep their arrays
            done: Future[ManufacturingError | None] = Future()
            done.set_result(manufacturing_error(base, self._pool, leaving_noise=True))
            self._begun = base, done
        return self._begun[1].result()


def _leaves_less(one: ManufacturingError, its: JointFit, other: ManufacturingError, others: JointFit) -> bool:
    """chi^2 of one rotor is below that of another one; its, others: the fits of one angle that they belong to."""
    if all(a.rate_hz == b.rate_hz for a, b in zip(one.fit.shots, other.fit.shots, strict=True)):
        return sum(one.fit.chi2) < sum(other.fit.chi2)
    # Only a driven thread's shots are decimated: both are compared at the instants of one angle.
    left, before = sum(chi2_beside_one_angle(one, its)), sum(chi2_beside_one_angle(other, others))
    if math.isfinite(left) and math.isfinite(before):
        return left < before
    return one.fit.chi2_per_dof < other.fit.chi2_per_dof


def _drive_is_doubtful(rotor: ManufacturingError) -> bool:
    """Its size or its delay is far from what the recording says, or it leaves more than noise."""
    level = 1.0 + _LIMITS.doubtful_sigma * math.sqrt(2.0 / sum(rotor.fit.dof))
    if rotor.fit.chi2_per_dof > level:
        return True
    return any(
        abs(v.drive_size - 1.0) > _LIMITS.doubtful_sigma * _FIT_LIMITS.drive_size_sd
        or abs(v.drive_delay_s) > _LIMITS.doubtful_sigma * _FIT_LIMITS.drive_delay_sd_s
        for v in rotor.fit.values
    )


def _without_drive(prepared: PreparedShot) -> PreparedShot:
    """A shot whose recorded drive may be wrong."""
    known = prepared.shot.rotor
    if known is None or known.drive is None:
        return prepared
    said = "the recorded drive does not explain the motion, so that each motion begins in any state"
    rotor = replace(known, drive=None, assumed=(*known.assumed, said))
    return replace(prepared, shot=replace(prepared.shot, rotor=rotor))
