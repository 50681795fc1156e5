"""One course over the amplitude, of shots that begin with different ones."""

from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.effect_search import candidates_for, declared_fit
from platform_daemon.diagnosis.fluctuation import search
from platform_daemon.diagnosis.fluctuation.first_look import differs_from_shot_to_shot
from platform_daemon.diagnosis.fluctuation.fluctuating import what_may_fluctuate
from platform_daemon.diagnosis.fluctuation.law_of_amplitude import of_one_course_of_amplitude
from platform_daemon.diagnosis.fluctuation.process import CourseInformation, CourseProcess, likeliest_process
from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.thread_pool import shot_pool
from platform_daemon.estimation.physics.models import JEWEL
from platform_daemon.estimation.physics.trajectory.turning_points import turning_points
from tests.kit.undeclared_shots import shots_with

FRICTION, _ = what_may_fluctuate(JEWEL)


def of_two_amplitudes(effects):
    """Fit of two shots of which the second one begins a third of a second later."""
    (first, other), _ = shots_with("jewel", effects, 2)
    late = other.record.samples[:, round(other.rate_hz / 3.0) :]
    shots = [first, replace(other, record=replace(other.record, samples=late, valid_to=None))]
    with shot_pool() as pool:
        prepared, refused = initial_fits(shots, JEWEL, pool)
        assert refused == []
        return declared_fit(prepared, JEWEL, pool)


def test_courses_of_one_law_are_one_course_over_the_amplitude_and_not_over_time():
    base = of_two_amplitudes([])
    time_s = np.linspace(0.0, 0.6, 60)
    shots = []
    for state in base.states:
        times, sizes = turning_points(JEWEL, state.dynamics, 0.6)
        course = 0.5 * np.interp(time_s, times, sizes) ** 2
        information = 1e6 * np.eye(60)
        shots.append(CourseInformation(time_s=time_s, unit=1.0, information=information, gradient=information @ course))
    start = CourseProcess(size=0.1, tau_s=0.1)
    each, over_time, over_amplitude = (
        likeliest_process(some, start, 1.0).log_likelihood
        for some in (
            shots,
            [CourseInformation.of_one_course(shots)],
            [of_one_course_of_amplitude(base, shots)],
        )
    )
    assert over_amplitude == pytest.approx(each, rel=1e-3)
    assert over_time < 0.98 * each


def test_the_search_for_a_fluctuation_ends_before_its_fits_where_a_law_explains_the_courses(monkeypatch):
    base = of_two_amplitudes([{"id": "angle_dependent_damping", "strength": 5.0}])
    monkeypatch.setattr(search, "fit_jointly", None)  # would raise
    with shot_pool() as pool:
        assert differs_from_shot_to_shot(base, FRICTION, pool)
        assert search.fluctuation_of(base, FRICTION, candidates_for(base), pool) is None
