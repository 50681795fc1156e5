"""Control charts against what is known of them: run lengths, regression, and simulated changes."""

import time

import numpy as np
import pytest

from platform_daemon.features.trends.chart import WEIGHT, chart
from platform_daemon.features.trends.ewma import ewma_run_length, ewma_width, steady_std
from platform_daemon.features.trends.prediction import course_of, temperature_terms


@pytest.mark.parametrize(("weight", "width", "shift", "length"), [
    (1.0, 3.0, 0.0, 370.40),  # a Shewhart chart of 3 sigma
    (0.10, 2.814, 0.0, 500.0), (0.10, 2.814, 1.0, 10.3),  # Lucas and Saccucci, Technometrics 32 (1990) 1, table 3
    (0.25, 2.998, 0.0, 500.0), (0.25, 2.998, 1.0, 11.1), (0.05, 2.615, 0.5, 28.7),
])  # fmt: skip
def test_run_lengths_are_those_of_the_literature(weight, width, shift, length):
    assert ewma_run_length(weight, width, shift) == pytest.approx(length, rel=0.01)


def test_a_width_alarms_as_often_as_it_says():
    width = ewma_width(WEIGHT, 300.0)
    rng, z, limit = np.random.default_rng(1), np.zeros(4000), width * steady_std(WEIGHT)
    first = np.zeros(4000)
    for k in range(1, 4000):
        z = (1.0 - WEIGHT) * z + WEIGHT * rng.standard_normal(4000)
        first[(first == 0) & (np.abs(z) > limit)] = k
    assert first.mean() == pytest.approx(300.0, rel=0.06)


def test_scores_of_what_follows_the_temperature_are_independent_and_normal():
    rng = np.random.default_rng(2)
    warm = 20.0 + 5.0 * np.sin(np.arange(600) / 30.0) + rng.normal(0.0, 0.3, 600)
    scores = []
    for _ in range(20):
        y = 5.0 + 1e-3 * warm + 2e-6 * warm**2 + 1e-5 * rng.standard_normal(600)
        scores.append(course_of(temperature_terms(warm), y, np.zeros(600, int))[1])
    found = np.array(scores)[:, 30:]
    assert np.isfinite(found).mean() > 0.98
    found = found[np.isfinite(found)]
    assert found.mean() == pytest.approx(0.0, abs=0.03)
    assert found.std() == pytest.approx(1.0, abs=0.03)
    assert np.mean(np.abs(found) > 2.0) == pytest.approx(0.0455, abs=0.008)


@pytest.mark.long
@pytest.mark.parametrize("known", [True, False])
def test_false_alarms_come_as_often_as_stated(known):
    rng, alarms, runs = np.random.default_rng(3), 0, 150
    for _ in range(runs):
        warm = 20.0 + np.cumsum(rng.normal(0.0, 0.3, 400)) if known else np.full(400, np.nan)
        y = (1e-3 * warm if known else 0.0) + 1e-5 * rng.standard_normal(400)
        alarms += chart(y, warm, 1000.0).alarm is not None
    stated = 1.0 - np.exp(-400 / 1000.0)
    assert alarms / runs == pytest.approx(stated, abs=3.5 * np.sqrt(stated * (1 - stated) / runs))


def test_a_step_is_found_where_it_is_and_the_points_after_it_teach_nothing():
    rng = np.random.default_rng(4)
    warm = 20.0 + 3.0 * np.sin(np.arange(300) / 5.0)
    y = 1e-3 * warm + 1e-5 * rng.standard_normal(300)
    y[200:] += 4e-5
    found = chart(y, warm, 20_000.0)
    assert found.alarm is not None
    assert abs(found.alarm.since - 200) <= 2
    assert found.alarm.noticed - 200 < 10
    assert found.alarm.stands
    assert found.alarm.shift > 2.0
    apart = y[250:] - found.terms[250:] @ found.learned.coefficients
    assert apart.mean() == pytest.approx(4e-5, rel=0.15)


def test_what_has_gone_back_does_not_stand():
    rng = np.random.default_rng(5)
    y = 1e-5 * rng.standard_normal(400)
    y[200:230] += 5e-5
    found = chart(y, np.full(400, np.nan), 20_000.0)
    assert found.alarm is not None
    assert not found.alarm.stands


def test_one_wild_point_is_no_change():
    rng = np.random.default_rng(6)
    y = 1e-5 * rng.standard_normal(300)
    y[150] = 1.0
    assert chart(y, np.full(300, np.nan), 20_000.0).alarm is None


def test_a_temperature_that_was_never_seen_says_nothing():
    warm = np.concatenate([np.full(60, 20.0), np.full(40, 30.0)])
    y = 1e-2 * (warm - 20.0) + 1e-5 * np.random.default_rng(7).standard_normal(100)
    found = chart(y, warm, 20_000.0)
    assert found.alarm is None
    assert np.isnan(found.score[60])


def test_neighbours_that_are_alike_widen_the_limits():
    rng, alarms = np.random.default_rng(8), 0
    for _ in range(60):
        y, z = np.zeros(600), 0.0
        for k in range(600):
            z = 0.6 * z + rng.standard_normal()
            y[k] = z
        alarms += chart(y, np.full(600, np.nan), 5000.0).alarm is not None
    assert alarms < 60 * 0.4  # all of them without


@pytest.mark.parametrize("y", [np.zeros(50), np.full(50, np.nan), np.array([]), np.array([1.0])])
def test_points_that_never_vary_or_are_none_are_no_change(y):
    found = chart(y, np.full(len(y), 20.0), 20_000.0)
    assert found.alarm is None
    assert len(found.score) == len(y)


@pytest.mark.parametrize(("at", "sigma", "least"), [(40, 5.0, 18), (60, 3.0, 18)])
def test_a_step_soon_after_the_beginning_is_no_reason_to_look_away(at, sigma, least):
    rng, found = np.random.default_rng(9), []
    for _ in range(20):
        y = 1e-5 * rng.standard_normal(300)
        y[at:] += sigma * 1e-5
        alarm = chart(y, np.full(300, np.nan), 240_000.0).alarm
        found += [] if alarm is None else [alarm.noticed - at]
    assert len(found) >= least
    assert 0 <= np.median(found) < 12


@pytest.mark.parametrize("shots", [(16, 1), (1, 16), (16, 1, 16, 1, 16, 1)])
def test_recordings_of_more_or_fewer_shots_than_those_before_are_no_change(shots):
    rng, alarms = np.random.default_rng(10), 0
    many = np.repeat(shots, 600 // len(shots))
    for _ in range(30):
        warm = 20.0 + np.cumsum(rng.normal(0.0, 0.2, 600))
        y = 1e-3 * warm + 1e-5 * rng.standard_normal(600) / np.sqrt(many)
        alarms += chart(y, warm, 240_000.0, many).alarm is not None
    assert alarms <= 1


def test_the_chart_of_ten_years_takes_no_second():
    rng = np.random.default_rng(11)
    warm = 20.0 + 3.0 * np.sin(np.arange(10_000) / 30.0)
    begun = time.process_time()
    chart(1e-3 * warm + 1e-5 * rng.standard_normal(10_000), warm, 240_000.0)
    assert time.process_time() - begun < 1.0
