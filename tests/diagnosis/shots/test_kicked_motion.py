"""A kicked swing against scipy's, and its derivatives against differences."""

import math
from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.shots.kicked_motion import Kick, KickedState, kicked_basis
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.physics.ring_down import dynamics_through
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from tests.kit.pendulum import NATURAL_HZ, RATE, kicked

W = 2.0 * math.pi * NATURAL_HZ
SAMPLES = 3000


def swinging(*kicks, amplitude=1.2, viscous=0.004):
    dynamics = dynamics_through(THREAD, w=W, values=(viscous * W,), phi=amplitude, v=0.0)
    return KickedState(dynamics, None, np.zeros(1), kicks)


def test_it_is_the_swing_that_scipy_integrates():
    change, at_period = 0.3, 4.321
    state = swinging(Kick(at_period / NATURAL_HZ, change * W))
    basis, slopes = kicked_basis(THREAD, state, 0, SAMPLES, 1.0 / RATE, STATE)
    expected = kicked(1.2, SAMPLES / RATE * NATURAL_HZ, at_period, change)
    assert np.abs(basis[0] - expected).max() < 1e-8
    np.testing.assert_allclose(slopes[0], basis[1], atol=1e-9)  # phi' / w


def test_a_kick_at_a_sample_is_at_that_sample():
    """49 / 49 Hz is 1 s, and 49 times 1 / 49 s a little less."""
    state = swinging(Kick(1.0, 2.0))
    assert 49 * (1.0 / 49.0) < 1.0
    basis, _ = kicked_basis(THREAD, state, 0, 100, 1.0 / 49.0, STATE)
    late, _ = kicked_basis(THREAD, swinging(Kick(1.0 - 1e-7, 2.0)), 0, 100, 1.0 / 49.0, STATE)
    np.testing.assert_allclose(basis[:2, 50:], late[:2, 50:], atol=1e-5)


def test_a_part_of_it_is_that_part_of_the_whole():
    state = swinging(Kick(1.7003, 2.0), Kick(5.0, -1.0))
    whole, _ = kicked_basis(THREAD, state, 0, SAMPLES, 1.0 / RATE, STATE)
    part, _ = kicked_basis(THREAD, state, 300, 375, 8.0 / RATE, STATE)
    np.testing.assert_allclose(part[:2], whole[:2, 2400:3000:8], atol=1e-9)


@pytest.mark.parametrize(("name", "place", "step"), [("theta", 0, 1e-5), ("w", 1, 1e-5), ("amplitude", 2, 1e-5)])
def test_its_derivatives_are_those_of_small_changes(name, place, step):
    state = swinging(Kick(1.7003, 2.0), Kick(5.0, -1.0))

    def at(change):
        other = replace(state.dynamics, **{name: getattr(state.dynamics, name) + change})
        return kicked_basis(THREAD, replace(state, dynamics=other), 0, SAMPLES, 1.0 / RATE, STATE)[0][:2]

    size = 3 + len(state.dynamics.values)
    basis, _ = kicked_basis(THREAD, state, 0, SAMPLES, 1.0 / RATE, STATE)
    rows = np.tensordot(state.dynamics.chain(THREAD).T, basis[2 : 2 + 2 * size].reshape(size, 2, -1), 1)[place]
    by_differences = (at(step) - at(-step)) / (2.0 * step)
    assert np.abs(by_differences - rows).max() < 1e-6 * np.abs(rows).max()


def test_a_kick_that_turns_the_rotor_over_leads_nowhere():
    with pytest.raises(LostTrajectoryError):
        kicked_basis(THREAD, swinging(Kick(1.0, 5.0 * W)), 0, SAMPLES, 1.0 / RATE, STATE)
