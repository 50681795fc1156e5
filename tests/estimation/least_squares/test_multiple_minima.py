"""Two minima of comparable chi2 are reported; one minimum reached twice, or a clearly worse one, is not."""

import numpy as np
import pytest

from platform_daemon.estimation.least_squares import progressive
from platform_daemon.estimation.least_squares.gauss_newton import FitState, NormalEquations
from platform_daemon.estimation.least_squares.multiple_minima import ambiguity
from platform_daemon.estimation.least_squares.observation_model import DipoleObservation
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters
from platform_daemon.estimation.physics.trajectory.turning_points import turning_points

DEGREES = 1000
SIZE = 11
FREE = np.ones(SIZE, dtype=bool)


def minimum(amplitude, chi2, w=1300.0, theta=1.0, loss=0.25):
    """With a standard deviation of 0.01 in everything."""
    dynamics = MotionParameters(w=w, theta=theta, amplitude=amplitude, values=(loss,))
    observation = DipoleObservation(0.01, np.eye(3), np.eye(3))
    state = FitState(dynamics, observation, np.zeros(3))
    zero = np.zeros(3)
    fields = {"chi2": chi2, "gradient": np.zeros(SIZE), "matrix": 1e4 * np.eye(SIZE)}
    rest = {n: zero for n in NormalEquations.__dataclass_fields__ if n not in fields}
    normal = NormalEquations(**fields, **rest)
    return progressive.Minimum(state=state, tabulated=state, normal=normal, moments=None)


def test_distinct_minima_of_comparable_chi2_are_reported():
    (warning,) = ambiguity([minimum(0.5, 1600.0), minimum(0.9, 1610.0)], THREAD, FREE, DEGREES)
    assert warning.startswith("start_ambiguous: chi2/dof = 1.6 at")
    assert "51.6 deg" in warning
    assert ambiguity([minimum(0.5, 1610.0, 1301.0), minimum(0.5, 1600.0)], THREAD, FREE, DEGREES)


@pytest.mark.parametrize(
    "found",
    [
        [minimum(0.5, 1600.0)],
        [minimum(0.5, 1600.0), minimum(0.51, 1601.0)],
        [minimum(0.5, 1600.0), minimum(-0.5, 1600.0)],
        [minimum(0.5, 1600.0), minimum(0.9, 1700.0)],
    ],
)
def test_one_minimum_and_clearly_worse_ones_are_not(found):
    assert ambiguity(found, THREAD, FREE, DEGREES) == ()


def test_a_held_parameter_does_not_distinguish_minima():
    free = FREE.copy()
    free[2] = False
    assert ambiguity([minimum(0.5, 1600.0), minimum(0.9, 1600.0)], THREAD, free, DEGREES) == ()


def test_one_motion_counted_from_its_next_turning_point_is_no_other():
    first = minimum(1.5, 1600.0, loss=80.0)
    times, sizes = turning_points(THREAD, first.state.dynamics, 0.004)
    theta = -1300.0 * times[1]
    assert abs(sizes[1] - 1.5) > 0.2
    next_one = minimum(-sizes[1], 1600.0, theta=theta, loss=80.0)
    assert ambiguity([first, next_one], THREAD, FREE, DEGREES) == ()
    assert ambiguity([next_one, first], THREAD, FREE, DEGREES) == ()
    assert ambiguity([first, minimum(-1.5, 1600.0, theta=theta, loss=80.0)], THREAD, FREE, DEGREES)
