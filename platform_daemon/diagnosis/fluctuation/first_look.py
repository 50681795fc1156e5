"""Whether something takes another course in each shot, by linear equations: the test before the costly fits."""

from __future__ import annotations

from concurrent.futures import Executor

import numpy as np

from platform_daemon.diagnosis.findings.knot_responses import knot_responses
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .fluctuating import Fluctuating
from .process import CourseInformation, CourseProcess, likeliest_process

_LIMITS = THRESHOLDS.fluctuation


def differs_from_shot_to_shot(base: JointFit, what: Fluctuating, pool: Executor) -> bool:
    """True if courses that differ are likelier than one course for all shots.

    base: the fit of the declared model.
    """
    model = base.hypothesis.model
    longest_s = max(float(p.time_s[-1]) for p in base.prepared)
    knots = np.linspace(0.0, longest_s, _LIMITS.first_knots)
    unit = what.unit_of_parameter(base.states)

    def one(k: int) -> CourseInformation:
        found = knot_responses(base.prepared[k], base.linear[k], model, [what.moving], knots)
        factor = base.noise_factor
        return CourseInformation(
            time_s=knots,
            unit=unit,
            information=found.information / factor,
            gradient=found.gradient / factor,
        )

    start = CourseProcess(size=_LIMITS.first_size, tau_s=_LIMITS.first_tau_share * longest_s)
    try:
        each = list(pool.map(one, range(len(base.prepared))))
        apart, alike = (
            likeliest_process(shots, start, what.largest) for shots in (each, [CourseInformation.of_one_course(each)])
        )
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return False
    return apart.log_likelihood > alike.log_likelihood
