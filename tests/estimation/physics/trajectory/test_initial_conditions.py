"""Initial conditions (phi_max, psi) and the state they name."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from platform_daemon.estimation.physics.trajectory.initial_conditions import (
    NoInitialConditionsError,
    initial_conditions_of_state,
    state_of_initial_conditions,
)


@given(st.floats(0.01, 2.5), st.floats(0.0, 2 * math.pi, exclude_max=True))
@settings(max_examples=80, deadline=None)
def test_initial_conditions_and_their_state_translate_both_ways(phi_max, psi):
    phi, v = state_of_initial_conditions(phi_max, psi)
    back_max, back_psi, _ = initial_conditions_of_state(phi, v)
    assert back_max == pytest.approx(phi_max, rel=1e-12)
    assert math.cos(back_psi - psi) == pytest.approx(1.0, abs=1e-12)
    assert 0.0 <= back_psi < 2 * math.pi


@pytest.mark.parametrize(("phi_max", "psi"), [(0.39, 5.84), (0.917, 3.863), (1.3, 0.0), (0.2, 1.6)])
def test_the_derivatives_of_the_initial_conditions_agree_with_differences(phi_max, psi):
    state = np.array(state_of_initial_conditions(phi_max, psi))
    _, _, jacobian = initial_conditions_of_state(*state)
    for k in range(2):
        h = 1e-6 * np.eye(2)[k]
        up, down = initial_conditions_of_state(*(state + h)), initial_conditions_of_state(*(state - h))
        turn = (up[1] - down[1] + math.pi) % (2 * math.pi) - math.pi
        assert np.allclose(jacobian[:, k], [(up[0] - down[0]) / 2e-6, turn / 2e-6], atol=1e-6)


@pytest.mark.parametrize("state", [(0.0, 0.0), (0.1, 2.5)])
def test_a_state_without_initial_conditions_is_an_error(state):
    with pytest.raises(NoInitialConditionsError):
        initial_conditions_of_state(*state)
