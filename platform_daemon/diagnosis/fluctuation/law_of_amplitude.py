"""One course for all shots as a function of the amplitude: what a law of angle or speed makes of each shot.

Shots that begin with one amplitude go through a law in the same time, and one course of time for all is as good as one
for each.  Shots of several fields do not: a course of one with the large amplitude is that of another one later on.
With a_k(t) the amplitude of shot k, and r the shot with the largest one, shot k at time t is where r is at the time
s_k(t) with a_r(s) = a_k(t).  Its knots are then x_k = M_k x_r with M_k linear interpolation in time, and information A
and gradient g of all shots about x_r are the sums of M_k^T A_k M_k and of M_k^T g_k.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.turning_points import turning_points

from .process import CourseInformation


def of_one_course_of_amplitude(base: JointFit, shots: Sequence[CourseInformation]) -> CourseInformation | None:
    """What shots tell about a course over the amplitude, at the times at which the largest swing has these amplitudes.

    base: the fit of the declared model, of which the amplitudes are; shots: of the same knots.  The course is twice as
    long as these, since the smaller swings go on where the largest one is at the end of its window.  None where one of
    them has hardly an amplitude in common with the largest one: one course could then be another one for each.

    Raises LostTrajectoryError.
    """
    time_s, step_s = shots[0].time_s, float(shots[0].time_s[1])
    longer_s: Array = step_s * np.arange(2 * len(time_s), dtype=np.float64)
    falls = [_fall_of(base, k, longer_s) for k in range(len(shots))]
    largest = min(falls, key=lambda fall: float(fall[0]))
    information, gradient = np.zeros((len(longer_s), len(longer_s))), np.zeros(len(longer_s))
    for one, fall in zip(shots, falls, strict=True):
        at_s = np.interp(fall[: len(time_s)], largest, longer_s)
        if np.mean(at_s <= time_s[-1]) < THRESHOLDS.fluctuation.common_amplitudes:
            return None
        at = _interpolation(longer_s, at_s)
        information += at.T @ one.information @ at
        gradient += at.T @ one.gradient
    return CourseInformation(time_s=longer_s, unit=shots[0].unit, information=information, gradient=gradient)


def _fall_of(base: JointFit, k: int, time_s: Array) -> Array:
    """-log of the amplitude of a shot at some times, (size,), that never falls."""
    times, sizes = turning_points(base.hypothesis.model, base.states[k].dynamics, float(time_s[-1]))
    logs = np.log(np.maximum(sizes, np.finfo(float).tiny))
    return -np.minimum.accumulate(np.interp(time_s, times, logs))


def _interpolation(time_s: Array, at_s: Array) -> Array:
    """(k, size) that takes values at (size,) `time_s` to (k,) `at_s` within these."""
    left = np.clip(np.searchsorted(time_s, at_s) - 1, 0, len(time_s) - 2)
    share = (at_s - time_s[left]) / (time_s[left + 1] - time_s[left])
    rows = np.arange(len(at_s))
    found = np.zeros((len(at_s), len(time_s)))
    found[rows, left], found[rows, left + 1] = 1.0 - share, share
    return found
