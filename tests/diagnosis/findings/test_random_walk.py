"""The score test of a walk's variance against known distributions, and the walk that it finds."""

import math

import numpy as np
import pytest
from scipy.stats import chi2, f

from platform_daemon.diagnosis.findings.random_walk import log_chance_of_walk, log_tail, walk


@pytest.mark.parametrize("size", [1, 3, 9])
@pytest.mark.parametrize("over", [0.2, 0.9, 2.0, 10.0, 60.0])
def test_tails_are_those_of_chi_squared_and_of_f(size, over):
    ones = np.ones(size)
    assert log_tail(ones, size * over, 1e9) == pytest.approx(chi2.logsf(size * over, size), rel=2e-3, abs=0.15)
    assert log_tail(ones, size * over, 12.0) == pytest.approx(f.logsf(over, size, 12), rel=2e-3, abs=0.15)


def test_a_tail_of_unequal_weights_is_that_of_many_draws():
    weights, rng = np.array([1.0, 0.3, 0.1, 0.01]), np.random.default_rng(3)
    draws = rng.standard_normal((400_000, 4)) ** 2 @ weights
    for value in (0.5, 2.0, 6.0, 10.0):
        assert math.exp(log_tail(weights, value, 1e9)) == pytest.approx(np.mean(draws > value), rel=0.1)


def test_chances_of_noise_hold_their_level():
    rng = np.random.default_rng(4)
    rows = np.cumsum(rng.standard_normal((200, 9)), axis=0) * np.geomspace(1.0, 1e3, 9)
    information = rows.T @ rows
    chances = [
        math.exp(log_chance_of_walk(information, rows.T @ (1.7 * rng.standard_normal(200)), 1.7**2, 1e6))
        for _ in range(1500)
    ]
    # Two tests that are much alike count as two: a little less often than that.
    assert 0.003 < np.mean(np.array(chances) < 0.01) <= 0.015
    assert 0.3 < np.mean(np.array(chances) < 0.5) <= 0.52


def test_a_walk_is_followed_within_its_band_and_noise_is_none():
    rng = np.random.default_rng(5)
    rows, steps = rng.standard_normal((400, 9)), 0.8 * rng.standard_normal(9)
    found = walk(rows.T @ rows, rows.T @ (rows @ steps + rng.standard_normal(400)), 1.0)
    assert found.evidence > 50.0
    assert np.all(np.abs(found.steps - steps) < 4.0 * np.sqrt(np.diag(found.covariance)))
    nothing = walk(rows.T @ rows, rows.T @ rng.standard_normal(400), 1.0)
    assert nothing.evidence < 3.0
