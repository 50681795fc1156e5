"""Does friction or frequency fluctuate along each ring-down, and which effects are there beside it?

1. Its courses are fitted while every receiver effect may have a size of its own in every shot, so that the
   courses need not stand in for an effect of the receiver.
2. Beside these courses the effects are chosen that all shots have in common, by linear steps.
3. Courses and strengths are fitted in turn, each time with the likeliest random process.

A law of angle, speed or time gives all shots of one field nearly the same course over time, and shots of several fields
nearly the same over the amplitude.  It is smooth, for it follows the amplitude.  A fluctuation is neither: one course
for all shots must be less likely than a course for each of them, and clearly so where it is smooth.  Where a smooth one
for all leaves all but nothing to each shot, the search ends before its costly fits.  One shot alone does not tell them
apart.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.regression.joint_fit import JointFit, fit_jointly, starting_point
from platform_daemon.diagnosis.selection.confounders import gain_of
from platform_daemon.diagnosis.selection.significance import LEVEL, log_chance
from platform_daemon.diagnosis.shots.linearisation import linearise_signal
from platform_daemon.diagnosis.shots.shot import PreparedShot
from platform_daemon.diagnosis.shots.torque_course import CourseState, TorqueCourse
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError

from .common_effects import common_effects
from .course_fit import CourseFit, fit_course, linearise_course
from .first_look import differs_from_shot_to_shot
from .fluctuating import Fluctuating
from .law_of_amplitude import of_one_course_of_amplitude
from .process import CourseInformation, CourseProcess, LikeliestProcess, likeliest_process

_LIMITS = THRESHOLDS.fluctuation


@dataclass(frozen=True, kw_only=True)
class FoundFluctuation:
    """A friction or a frequency that fluctuates.

    Attributes:
        what: of these two.
        likeliest: its random process.
        unit: what a size of 1 stands for, rad/s^2.
        joint_fit: of all shots with their courses, and with the effects that they have in common.
    """

    what: Fluctuating
    likeliest: LikeliestProcess
    unit: float
    joint_fit: JointFit

    @property
    def tau_is_determined(self) -> bool:
        """The correlation time is told from any other one."""
        longest_s = max(float(p.time_s[-1]) for p in self.joint_fit.prepared)
        near = self.likeliest.process.tau_s < _LIMITS.undetermined_tau * longest_s
        return near and self.likeliest.log_tau_std < 1.0


def fluctuation_of(
    base: JointFit, what: Fluctuating, candidates: Sequence[Candidate], pool: Executor
) -> FoundFluctuation | None:
    """A fluctuation that leaves noise only, beside effects that all shots share; None if there is none.

    base: the fit of the declared model; candidates: torque and receiver effects.
    """
    if len(base.prepared) < 2 or not differs_from_shot_to_shot(base, what, pool):
        return None
    try:
        return _found(base, what, candidates, pool)
    except (LostTrajectoryError, np.linalg.LinAlgError):
        return None


def fits_at_neighbouring_processes(found: FoundFluctuation, pool: Executor) -> Iterator[tuple[JointFit, float]]:
    """The joint fit with its process moved along each axis of its errors, and how many such moves a standard deviation
    has; nothing along an axis on which there is no such fit."""
    at = found.joint_fit
    for process, times in found.likeliest.neighbours():
        states = _with_process(at.states, found.what, process, found.unit)
        with suppress(LostTrajectoryError, np.linalg.LinAlgError):
            yield fit_jointly(at.prepared, at.hypothesis, pool, states, at.strengths), times


def _found(
    base: JointFit, what: Fluctuating, candidates: Sequence[Candidate], pool: Executor
) -> FoundFluctuation | None:
    fits = _first_courses(base, what, _apart(base, candidates), pool)
    if not _is_noise(base, fits):
        return None
    likeliest, unit, information = _process(fits, what, _first_process(base))
    if _is_surely_law(base, what, likeliest, information):
        return None
    states = _with_process([f.state for f in fits], what, likeliest.process, unit)
    hypothesis, strengths = common_effects(base, states, candidates, pool)
    for _ in range(_LIMITS.most_passes):
        at = fit_jointly(base.prepared, hypothesis, pool, states, strengths)
        strengths, before = at.strengths, likeliest
        fits = _linearised(at, pool)
        likeliest, unit, information = _process(fits, what, before.process)
        states = _with_process([f.state for f in fits], what, likeliest.process, unit)
        if likeliest.process.near(before.process):
            break
    at = fit_jointly(base.prepared, hypothesis, pool, states, strengths)  # with the process of the last turn
    at = _still_sure(at, float(len(candidates)), pool)
    noise = at.chi2_per_dof < THRESHOLDS.regression.noise_chi2_per_dof
    if not noise or not likeliest.sure or _may_be_law(base, what, likeliest, information):
        return None
    return FoundFluctuation(what=what, likeliest=likeliest, unit=unit, joint_fit=at)


def _is_surely_law(
    base: JointFit, what: Fluctuating, likeliest: LikeliestProcess, information: Sequence[CourseInformation]
) -> bool:
    """One course for all shots, as smooth as that of a law, leaves all but nothing to each of them: the courses with
    which a search begins still contain what the shots have in common, so that the rest may be small beside it."""
    if not _is_smooth(likeliest, information):
        return False
    own = likeliest.log_likelihood
    shared = _of_one_course(base, what, likeliest, information)
    return shared > max(_LIMITS.sure_law_share * own, own - _LIMITS.sure_law_log)


def _may_be_law(
    base: JointFit, what: Fluctuating, likeliest: LikeliestProcess, information: Sequence[CourseInformation]
) -> bool:
    """One course for all shots is as likely as one for each, or nearly so where it is as smooth as that of a law."""
    limit = _LIMITS.law_share if _is_smooth(likeliest, information) else _LIMITS.any_law_share
    return not _of_one_course(base, what, likeliest, information) < limit * likeliest.log_likelihood


def _is_smooth(likeliest: LikeliestProcess, information: Sequence[CourseInformation]) -> bool:
    """A law follows the amplitude, which falls all along a ring-down: its course does not change sooner."""
    return likeliest.process.tau_s > _LIMITS.smooth_share * float(information[0].time_s[-1])


def _of_one_course(
    base: JointFit, what: Fluctuating, likeliest: LikeliestProcess, information: Sequence[CourseInformation]
) -> float:
    """Log likelihood of one course for all shots: over time, or where it is smooth over the amplitude if that is
    likelier.  A course over the amplitude that is not smooth could be another one for each shot, at its own amplitudes.
    """

    def found(one: CourseInformation) -> float:
        return likeliest_process([one], likeliest.process, what.largest).log_likelihood

    over_time = found(CourseInformation.of_one_course(information))
    if base.hypothesis.model.time_dependent or not _is_smooth(likeliest, information):
        return over_time
    with suppress(LostTrajectoryError, np.linalg.LinAlgError):
        over_amplitude = of_one_course_of_amplitude(base, information)
        return over_time if over_amplitude is None else max(over_time, found(over_amplitude))
    return over_time


def _still_sure(at: JointFit, trials: float, pool: Executor) -> JointFit:
    """Without effects that are no longer significant where all others are fitted with them.

    Raises LostTrajectoryError.
    """
    while at.hypothesis.common:
        worst = min(at.hypothesis.common, key=lambda c: gain_of(at, c))
        if log_chance(gain_of(at, worst), worst.size, trials) < LEVEL:
            break
        fewer = at.hypothesis.without(worst)
        at = fit_jointly(at.prepared, fewer, pool, *starting_point(at, fewer))
    return at


def _first_process(base: JointFit) -> CourseProcess:
    """Where the search for the likeliest one begins."""
    longest_s = max(float(p.time_s[-1]) for p in base.prepared)
    return CourseProcess(size=_LIMITS.first_size, tau_s=_LIMITS.first_tau_share * longest_s)


def _first_courses(base: JointFit, what: Fluctuating, beside: Sequence[Candidate], pool: Executor) -> list[CourseFit]:
    """Courses of all shots, each with receiver effects of its own.  Raises LostTrajectoryError."""
    longest_s, knots = max(float(p.time_s[-1]) for p in base.prepared), what.knots
    step_s = longest_s / (knots - 1)
    times: Array = step_s * np.arange(knots, dtype=np.float64)
    process = _first_process(base)
    nothing = replace(
        TorqueCourse.none_of(base.hypothesis.model, step_s, process.root(times, what.unit(base.states)), what.law),
        pumped_per_s=what.pumped_per_s(process, base.states),
    )

    def one(shot: PreparedShot, state: FitState) -> CourseFit:
        begin = CourseState(state.dynamics, state.observation, state.offsets, nothing)
        return fit_course(shot, base.hypothesis, begin, base.strengths, beside)

    return list(pool.map(one, base.prepared, base.states))


def _linearised(at: JointFit, pool: Executor) -> list[CourseFit]:
    """All shots of a joint fit with courses.  Raises LostTrajectoryError."""

    def one(shot: PreparedShot, state: FitState) -> CourseFit:
        assert isinstance(state, CourseState)
        return linearise_course(shot, at.hypothesis, state, at.strengths)

    return list(pool.map(one, at.prepared, at.states))


def _process(
    fits: Sequence[CourseFit], what: Fluctuating, start: CourseProcess
) -> tuple[LikeliestProcess, float, list[CourseInformation]]:
    """The likeliest process, what a size of 1 stands for in rad/s^2, and what each shot tells."""
    unit = what.unit([f.state for f in fits])
    information = [f.information(unit) for f in fits]
    return likeliest_process(information, start, what.largest), unit, information


def _with_process(
    states: Sequence[FitState], what: Fluctuating, process: CourseProcess, unit: float
) -> list[CourseState]:
    """States whose courses obey a process."""
    pumped_per_s = what.pumped_per_s(process, states)
    found = []
    for state in states:
        assert isinstance(state, CourseState)
        root = process.root(state.course.time_s, unit)
        found.append(replace(state, course=replace(state.course, root=root, pumped_per_s=pumped_per_s)))
    return found


def _is_noise(base: JointFit, fits: Sequence[CourseFit]) -> bool:
    """True if courses and receiver effects of every shot's own leave noise only."""
    chi2 = sum(f.chi2 for f in fits)
    return chi2 < THRESHOLDS.regression.noise_chi2_per_dof * sum(p.dof for p in base.prepared)


def _apart(base: JointFit, candidates: Sequence[Candidate]) -> list[Candidate]:
    """Receiver effects with columns that neither the declared parameters nor those before them can replace."""
    shot, linear = base.prepared[0], base.linear[0]
    offered = [c for c in candidates if c.change is not None and c.size == 1 and c.columns is not None]
    full = linearise_signal(shot, base.hypothesis.augmented, base.full_state(0))
    columns = np.stack([shot.white(c.columns(full))[0] for c in offered if c.columns is not None])
    columns /= np.maximum(np.linalg.norm(columns, axis=1, keepdims=True), 1e-300)
    columns = linear.without_own(columns.T).T
    found: list[Candidate] = []
    while len(found) < len(offered):
        sizes = np.linalg.norm(columns, axis=1)
        k = int(np.argmax(sizes))
        if sizes[k] < _LIMITS.apart_share:
            break
        found.append(offered[k])
        along = columns[k] / sizes[k]
        columns -= np.outer(columns @ along, along)
    return found
