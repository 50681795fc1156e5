"""Where a shot's motion is anchored, and how its fit begins."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from platform_daemon.diagnosis.shots import initial_fits as of_shots
from platform_daemon.diagnosis.shots.initial_fits import anchored_before, initial_fits
from platform_daemon.estimation.least_squares.gauss_newton import FitState
from platform_daemon.estimation.least_squares.observation_model import AngleObservation
from platform_daemon.estimation.physics.models import JEWEL, THREAD
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError, MotionParameters, Trajectory
from platform_daemon.estimation.physics.trajectory.turning_points import turning_points
from platform_daemon.estimation.solve import find_minimum_coarsely
from tests.kit.undeclared_shots import shots_with


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


def test_a_shot_whose_frequency_wanders_begins_as_if_noise_were_a_part_of_the_signal(monkeypatch):
    wanders = [{"id": "frequency_fluctuation", "strength": 0.18, "tau_s": 0.086}]
    shots, truths = shots_with("jewel", wanders, 3, rx_s=2.0, seed=8)
    coarse = []
    monkeypatch.setattr(
        of_shots, "find_minimum_coarsely", lambda *a: coarse.append(find_minimum_coarsely(*a)) or coarse[-1]
    )
    with ThreadPoolExecutor(2) as pool:
        prepared, refused = initial_fits(shots, JEWEL, pool)
    assert coarse
    assert refused == []
    for one, truth in zip(prepared, truths, strict=True):
        off_hz = one.state.dynamics.w / (2.0 * math.pi) - truth["f_nat_hz"]
        assert abs(off_hz) < 3.0 * wanders[0]["strength"]
