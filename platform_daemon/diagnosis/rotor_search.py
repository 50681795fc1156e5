"""The search for a rotor of five degrees of freedom, before that for effects of one angle."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .findings.rotor_findings import leaves_noise
from .regression.hypothesis import Hypothesis
from .regression.joint_fit import JointFit, fit_jointly
from .rigid_body.defects import ManufacturingError, manufacturing_error
from .rigid_body.plane_test import PlaneTest
from .shots.shot import PreparedShot
from .thresholds import THRESHOLDS


def rotor_of(
    prepared: Sequence[PreparedShot], model: RingDownModel, plane: PlaneTest, pool: Executor
) -> tuple[JointFit, ManufacturingError] | None:
    """The declared model's fit, and the manufacturing error that explains what it cannot; None if none does."""
    if any(s.shot.rotor is None for s in prepared):
        return None
    try:
        declared = fit_jointly(prepared, Hypothesis(model), pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None
    if not plane.leaves and is_quiet(declared):
        return None
    rotor = manufacturing_error(declared, pool)
    if rotor is None and plane.leaves and any(s.shot.rotor is not None and s.shot.rotor.drive for s in prepared):
        declared = replace(declared, prepared=tuple(map(_without_drive, declared.prepared)))
        rotor = manufacturing_error(declared, pool)
    return None if rotor is None or not (plane.leaves or leaves_noise(rotor)) else (declared, rotor)


def _without_drive(prepared: PreparedShot) -> PreparedShot:
    """A shot whose recorded drive may be wrong."""
    known = prepared.shot.rotor
    assert known is not None
    said = "the recorded drive does not explain the motion, so that each motion begins in any state"
    rotor = replace(known, drive=None, assumed=(*known.assumed, said))
    return replace(prepared, shot=replace(prepared.shot, rotor=rotor))


def is_quiet(fit: JointFit) -> bool:
    """One angle leaves hardly more than noise."""
    return fit.chi2_per_dof < THRESHOLDS.regression.noise_chi2_per_dof
