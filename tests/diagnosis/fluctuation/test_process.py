"""A random process as noise against dense matrices, and the likeliest process of courses that are drawn."""

from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.fluctuation.process import CourseInformation, CourseProcess, likeliest_process
from platform_daemon.diagnosis.shots.torque_course import CourseState, ProcessNoise, TorqueCourse, friction_law
from platform_daemon.estimation.physics.models import JEWEL, model_named
from platform_daemon.estimation.physics.torques import TERMS
from platform_daemon.estimation.physics.torques.torque_course import CONSTANT, HERTZ
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory

TIMES = np.linspace(0.0, 1.5, 60)
FRICTION = 1200.0


@pytest.fixture
def drawn():
    """Answers (knots, rows), the covariance of the rows, and rows with noise and process."""
    rng = np.random.default_rng(4)
    answers = rng.normal(size=(6, 80)) * np.array([30.0, 10.0, 3.0, 1.0, 0.1, 0.001])[:, None]
    root = np.tril(rng.normal(size=(6, 6))) + 3.0 * np.eye(6)
    columns = answers.T @ root
    return ProcessNoise.of(answers, root), answers, root, np.eye(80) + columns @ columns.T, rng.normal(size=(3, 80))


def test_rows_without_the_noise_have_the_squares_of_generalised_least_squares(drawn):
    process, _, _, covariance, rows = drawn
    out = process.taken_out(rows)
    assert out @ out.T == pytest.approx(rows @ np.linalg.solve(covariance, rows.T), rel=1e-9)


def test_the_likeliest_course_is_the_conditional_mean(drawn):
    process, answers, root, covariance, rows = drawn
    expected = root @ root.T @ answers @ np.linalg.solve(covariance, rows[0])
    assert process.likeliest(process.taken_out(rows[0])) == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_a_split_predicts_the_other_rows_as_the_covariance_says(drawn):
    process, _, _, covariance, rows = drawn
    kept = np.arange(80) < 33
    split = process.split_at(kept)
    first, (rest, left) = split.first(process.taken_out(rows)), split.rest(process.taken_out(rows))
    inside, beside = covariance[np.ix_(kept, kept)], covariance[np.ix_(~kept, kept)]
    assert first @ first.T == pytest.approx(rows[:, kept] @ np.linalg.solve(inside, rows[:, kept].T), rel=1e-8)
    predicted = rows[:, ~kept] - rows[:, kept] @ np.linalg.solve(inside, beside.T)
    assert left == pytest.approx(predicted, abs=1e-8)
    whole = np.sum(first**2, axis=1) + np.sum(rest**2, axis=1)
    assert whole == pytest.approx(np.sum(process.taken_out(rows) ** 2, axis=1), rel=1e-9)


def informations(process, shots, seed, *, common=False):
    """Of shots whose knots are seen with errors of 3 %, a course of each or one of all."""
    rng = np.random.default_rng(seed)
    root = process.root(TIMES, FRICTION)
    precision = 1.0 / (0.03 * FRICTION) ** 2
    course = root @ rng.normal(size=TIMES.size)
    found = []
    for _ in range(shots):
        own = course if common else root @ rng.normal(size=TIMES.size)
        seen = own + rng.normal(size=TIMES.size) / np.sqrt(precision)
        found.append(
            CourseInformation(
                time_s=TIMES,
                unit=FRICTION,
                information=precision * np.eye(TIMES.size),
                gradient=precision * seen,
            )
        )
    return found


@pytest.mark.parametrize("truth", [CourseProcess(size=0.2, tau_s=0.1), CourseProcess(size=0.1, tau_s=0.3)])
def test_size_and_correlation_time_come_out_within_their_errors(truth):
    found = likeliest_process(informations(truth, 12, 8), CourseProcess(size=0.15, tau_s=0.15), 1.0)
    assert abs(np.log(found.process.size / truth.size)) < 3.0 * found.log_size_std
    assert abs(np.log(found.process.tau_s / truth.tau_s)) < 3.0 * found.log_tau_std
    assert found.log_size_std < 0.3
    assert found.sure


def test_neighbours_lie_a_standard_deviation_away_along_both_axes_of_the_errors():
    found = likeliest_process(
        informations(CourseProcess(size=0.2, tau_s=0.1), 12, 8), CourseProcess(size=0.15, tau_s=0.15), 1.0
    )
    moves = []
    for process, times in found.neighbours():
        moved = np.log([process.size / found.process.size, process.tau_s / found.process.tau_s])
        moves.append(times * moved)
    assert np.sum([np.outer(m, m) for m in moves], axis=0) == pytest.approx(found.log_covariance)
    unknown = replace(found, log_covariance=np.diag([0.01, 9.0]))
    assert [round(times, 2) for _, times in unknown.neighbours()] == [1.0, 6.0]


def test_noise_alone_is_no_fluctuation():
    nothing = informations(CourseProcess(size=1e-9, tau_s=0.1), 6, 2)
    assert not likeliest_process(nothing, CourseProcess(size=0.1, tau_s=0.1), 1.0).sure


@pytest.mark.parametrize("common", [False, True])
def test_one_course_for_all_shots_is_likelier_only_where_it_is_one(common):
    shots = informations(CourseProcess(size=0.2, tau_s=0.2), 4, 5, common=common)
    start = CourseProcess(size=0.1, tau_s=0.1)
    apart = likeliest_process(shots, start, 1.0).log_likelihood
    alike = likeliest_process([CourseInformation.of_one_course(shots)], start, 1.0).log_likelihood
    assert (alike > apart) is common


def test_the_course_keeps_the_law_of_the_declared_model_beside_other_frictions():
    course = TorqueCourse.none_of(JEWEL, 0.02, np.eye(5), friction_law(JEWEL))
    assert course.law == HERTZ
    assert friction_law(model_named("jewel_constant_friction")) == CONSTANT
    wider = JEWEL.with_terms("jewel+coulomb_friction", TERMS["coulomb_friction"])
    motion = MotionParameters(w=1340.0, theta=0.0, amplitude=0.9, values=(0.1, 1300.0, 0.0))
    state = CourseState(motion, None, np.zeros(3), replace(course, values=np.full(5, 100.0)))
    beside = course.model(wider), state.course.extended(state)
    alone = replace(state, dynamics=replace(motion, values=motion.values[:2]))
    for_one = course.model(JEWEL), alone.course.extended(alone)
    found = [Trajectory(m, s.dynamics, 0.1).basis(0, 900, 1e-4, STATE)[0] for m, s in (beside, for_one)]
    assert found[0] == pytest.approx(found[1], abs=1e-12)
