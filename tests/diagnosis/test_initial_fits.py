"""Where a shot's motion is anchored."""

import math

import numpy as np
import pytest

from platform_daemon.diagnosis.shots.initial_fits import anchored_before
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.observation_model import AngleObservation
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError, MotionParameters, Trajectory
from platform_daemon.estimation.physics.trajectory.turning_points import turning_points


def angle(dynamics):
    return Trajectory(THREAD, dynamics, 5.0).basis(0, 500, 0.01, STATE)[0]


def test_a_swing_released_at_the_first_sample_is_not_anchored_half_a_cycle_later():
    w = 2.0 * math.pi
    released = MotionParameters(w=w, theta=0.02, amplitude=0.8, values=(0.05,))
    times, sizes = turning_points(THREAD, released, 3.0)
    later = MotionParameters(w=w, theta=-w * float(times[1]), amplitude=-float(sizes[1]), values=(0.05,))
    assert np.abs(angle(later) - angle(released)).max() < 1e-9
    with pytest.raises(LostTrajectoryError):  # no effect could move the release to a later instant
        angle(MotionParameters(w=w, theta=later.theta - 0.05, amplitude=later.amplitude, values=(0.05,)))
    state = anchored_before(FitState(later, AngleObservation(), np.zeros(1)), THREAD)
    assert state.dynamics.theta > 0.5
    assert np.abs(angle(state.dynamics) - angle(released)).max() < 1e-9
    near = FitState(released, AngleObservation(), np.zeros(1))
    assert anchored_before(near, THREAD) is near
