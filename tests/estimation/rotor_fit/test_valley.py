"""Steps of a rotor's fit, against bounded least squares by scipy."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from platform_daemon.estimation.rotor_fit.valley import limited_step


@pytest.mark.parametrize("seed", range(8))
def test_what_goes_along_with_a_limited_component_is_solved_for(seed):
    drawn = np.random.default_rng(seed)
    columns = drawn.normal(size=(40, 6)) @ np.diag(10.0 ** drawn.uniform(-2.0, 1.0, 6))
    columns[:, 1] += 3.0 * columns[:, 0]  # two that the data tell only together
    left = drawn.normal(size=40) * 10.0
    most = np.array([0.5, np.inf, np.inf, 0.5, np.inf, np.inf])
    step = limited_step(columns.T @ columns, columns.T @ left, most)
    by_scipy = lsq_linear(columns, left, bounds=(-most, most), method="bvls").x
    assert step == pytest.approx(by_scipy, rel=1e-6, abs=1e-9)


def test_a_component_that_is_cut_off_alone_leaves_the_floor():
    matrix = np.array([[1.0, 0.999], [0.999, 1.0]]) * 1e4
    gradient = matrix @ np.array([3.0, -3.0])
    held = limited_step(matrix, gradient, np.array([0.5, np.inf]))
    cut = np.array([0.5, -3.0])

    def fall(step):
        return 2.0 * gradient @ step - step @ matrix @ step

    assert fall(held) > 0.0 > fall(cut)
