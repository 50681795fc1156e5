"""Dahl's friction without a memory against scipy's integration of the bristle that has one."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from platform_daemon.estimation.moments.workspace import Workspace
from platform_daemon.estimation.physics.models import model_named
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory

W = 2.0 * math.pi
TIME = np.arange(3000) / 200.0


def by_scipy(friction, displacement, amplitude, damping):
    """The angle at TIME; friction: over I w^2."""

    def rates(_, y):
        pull = -W * W * (math.sin(y[0]) + friction * y[2]) - 2.0 * damping * y[1]
        return y[1], pull, (y[1] - abs(y[1]) * y[2]) / displacement

    begin = amplitude, 0.0, math.tanh(amplitude / displacement)  # as it was swinging so before
    return solve_ivp(rates, (0.0, TIME[-1]), begin, "LSODA", TIME, rtol=1e-11, atol=1e-13, max_step=0.01).y[0]


@pytest.mark.parametrize(
    ("friction", "displacement", "amplitude", "most"),
    [(0.005, 0.005, 1.2, 1e-5), (0.01, 0.03, 1.5, 5e-5), (0.003, 0.003, 0.3, 2e-5), (0.003, 0.3, 0.5, 3e-4)],
)
def test_a_contact_that_is_a_spring_before_it_slides_needs_no_memory(friction, displacement, amplitude, most):
    damping = 0.01
    true = by_scipy(friction, displacement, amplitude, damping)
    motion = MotionParameters(w=W, theta=0.0, amplitude=amplitude, values=(damping, friction * W * W, displacement))
    model = model_named("thread+dahl_friction")
    found = Trajectory(model, motion, TIME[-1]).basis(0, TIME.size, TIME[1], STATE)
    assert np.abs(found[0] - true).max() < most
    tabulated = Workspace(model).basis(motion, 0, TIME.size, TIME[1], STATE)
    assert np.abs(tabulated[0] - found[0]).max() < 1e-5 * amplitude
    assert np.abs(tabulated - found).max() < 3e-3 * np.abs(found).max()
