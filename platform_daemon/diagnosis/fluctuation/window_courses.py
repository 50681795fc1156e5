"""Does N50 agree with D30 once each window has a course of its own?"""

from __future__ import annotations

import math
from concurrent.futures import Executor

import numpy as np

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.regression.parameters import WindowDifference
from platform_daemon.diagnosis.shots.torque_course import CourseState
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.screening.windows import select_window

from .course_fit import CourseFit, fit_course


def window_disagreement_of_courses(at: JointFit, pool: Executor) -> dict[str, float]:
    """How significant N50 - D30 is, in standard deviations, by parameter, with the strengths of effects held.

    at: with courses.  Empty where no shot can be fitted in both windows.
    """
    pairs = [p for p in pool.map(lambda k: _both(at, k), range(len(at.prepared))) if p is not None]
    if not pairs:
        return {}
    short, long = np.array([a for a, _ in pairs]), np.array([b for _, b in pairs])
    differences = short[:, 0] - long[:, 0]
    variances = short[:, 1] ** 2 - long[:, 1] ** 2
    fitted = np.all(short[:, 1] > 0.0, axis=0)  # not what the model holds
    return {
        name: WindowDifference.of_shots(differences[:, k], variances[:, k]).sigma
        for k, name in enumerate(_names(at))
        if fitted[k]
    }


def _both(at: JointFit, k: int) -> tuple[Array, Array] | None:
    """Values and standard deviations (2, parameters) over N50 and D30; None where a fit does not settle."""
    shot, state = at.prepared[k], at.states[k]
    assert isinstance(state, CourseState)
    found = []
    for window in ("n50", "d30"):
        chosen = select_window(
            shot.shot.record, window, state.dynamics.w / (2.0 * math.pi), np.asarray(shot.shot.noise.sd)
        )
        inside = shot.time_s < chosen.last * shot.shot.record.dt_s
        try:
            fit = fit_course(shot, at.hypothesis, state, at.strengths, rows=np.tile(inside, shot.shot.record.channels))
        except (LostTrajectoryError, np.linalg.LinAlgError):
            return None
        if not fit.settled:
            return None
        found.append(_values(at, fit))
    return found[0], found[1]


def _names(at: JointFit) -> list[str]:
    """Public names of the parameters that are compared."""
    dipole = isinstance(at.states[0].observation, DipoleObservation)
    return ["f_nat_hz", *(c.name for c in at.hypothesis.model.coefficients), *(["m_r_am2"] if dipole else [])]


def _values(at: JointFit, fit: CourseFit) -> Array:
    """Values and standard deviations of a fit, in the order of the names."""
    d, count = fit.state.dynamics, len(at.hypothesis.model.coefficients)
    values, places = [d.w / (2.0 * math.pi), *d.values], [1, *range(3, 3 + count)]
    if isinstance(fit.state.observation, DipoleObservation):
        values, places = [*values, fit.state.observation.m_r], [*places, 3 + count]
    stds = np.sqrt(np.diag(fit.own_covariance()))[places]
    stds[0] /= 2.0 * math.pi
    return np.array([values, stds])
