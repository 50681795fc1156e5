"""The cone about a direction whose rotation is uncertain, against draws."""

import math

import numpy as np
import pytest

from drivers.errors import InputError
from platform_daemon.uncertainty.budget import coverage_factor
from platform_daemon.uncertainty.cone import cone_angle


@pytest.mark.parametrize("variances", [(1.0, 1.0, 1.0), (1.0, 0.3, 0.1), (1.0, 1e-9, 1e-9), (4.0, 4.0, 0.0)])
@pytest.mark.parametrize("coverage", [0.683, 0.95, 0.99])
def test_it_contains_any_direction_and_no_more_than_the_worst(variances, coverage):
    random = np.random.default_rng(5)
    axes = np.linalg.qr(random.standard_normal((3, 3)))[0]
    covariance = 1e-6 * axes @ np.diag(variances) @ axes.T
    angle = cone_angle(covariance, coverage)
    turned = random.multivariate_normal(np.zeros(3), covariance, 100_000, method="svd")

    def inside(direction):
        return float(np.mean(np.linalg.norm(np.cross(turned, direction), axis=1) <= angle))

    assert inside(axes[:, 2]) == pytest.approx(coverage, abs=0.004)
    for direction in random.standard_normal((10, 3)):
        assert inside(direction / np.linalg.norm(direction)) >= coverage - 0.004


def test_with_few_degrees_of_freedom_it_is_wider_as_the_interval_of_an_angle_is():
    one = np.diag([0.0, 0.0, 1e-8])
    for dof in (1.0, 4.0, 30.5):
        assert cone_angle(one, 0.95, dof) == pytest.approx(1e-4 * coverage_factor(0.95, dof), rel=2e-3)
    random = np.random.default_rng(6)
    covariance = 1e-8 * np.diag([0.1, 0.5, 1.0])
    drawn = (
        random.multivariate_normal(np.zeros(3), covariance, 200_000)
        / np.sqrt(random.chisquare(4.0, 200_000) / 4.0)[:, None]
    )
    inside = np.linalg.norm(drawn[:, 1:], axis=1) <= cone_angle(covariance, 0.95, 4.0)
    assert float(np.mean(inside)) == pytest.approx(0.95, abs=0.002)


def test_what_is_not_known_at_all_is_half_a_turn():
    assert cone_angle(np.diag([4.0, 4.0, 4.0]), 0.95) == math.pi


def test_of_one_axis_it_is_the_interval_and_of_two_alike_that_of_chi_squared():
    assert cone_angle(np.diag([0.0, 0.0, 4e-6]), 0.95) == pytest.approx(1.95996 * 2e-3, rel=1e-3)
    assert cone_angle(np.diag([1e-6, 4e-6, 4e-6]), 0.95) == pytest.approx(2e-3 * math.sqrt(5.99146), rel=1e-5)
    assert cone_angle(np.zeros((3, 3)), 0.95) == 0.0
    with pytest.raises(InputError, match="coverage"):
        cone_angle(np.eye(3), 1.0)
