"""A torque with a course along the ring-down: its derivatives, and its motion against an independent integrator."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from platform_daemon.estimation.physics.models import JEWEL
from platform_daemon.estimation.physics.torques.torque_course import (
    CONSTANT,
    HERTZ,
    SINE,
    torque_course,
    torque_course_term,
)
from platform_daemon.estimation.physics.trajectory.basis_functions import STATE
from platform_daemon.estimation.physics.trajectory.direct import MotionParameters, Trajectory

F_NAT_HZ, LAMBDA, FRICTION, AMPLITUDE = 213.0, 0.1, 1300.0, 0.9
STEP_S = 0.01
KNOTS = np.array([400.0, -300.0, 100.0, 500.0, -200.0])  # rad/s^2
RATE_HZ, COUNT = 20_000.0, 1200  # beyond the last knot


def parameters(knots=KNOTS, amplitude=AMPLITUDE, law=HERTZ):
    values = (LAMBDA, FRICTION, STEP_S, law, 0.0, *knots)
    return MotionParameters(w=2.0 * math.pi * F_NAT_HZ, theta=0.0, amplitude=amplitude, values=values)


def course_model(*, frozen=False):
    return JEWEL.with_terms("jewel+torque_course", torque_course_term(KNOTS.size, frozen=frozen))


def basis(d, *, frozen=False):
    return Trajectory(course_model(frozen=frozen), d, COUNT / RATE_HZ).basis(0, COUNT, 1.0 / RATE_HZ, STATE)


def independent(law=HERTZ):
    """Angles (COUNT,) by scipy, half cycle by half cycle: the sign of the friction changes at turning points only."""
    w = 2.0 * math.pi * F_NAT_HZ
    times, knots_s = np.arange(COUNT) / RATE_HZ, STEP_S * np.arange(KNOTS.size)
    neighbours = np.concatenate([KNOTS[:1], KNOTS, KNOTS[-1:]])
    course = CubicHermiteSpline(knots_s, KNOTS, (neighbours[2:] - neighbours[:-2]) / (2.0 * STEP_S))

    def turning(t, y, side):
        return y[1]

    turning.terminal = True

    def rates(t, y, side):
        more = float(course(min(t, knots_s[-1])))
        friction, square = (FRICTION, w**2 + more) if law == SINE else (FRICTION + more, w**2)
        load = max(math.cos(y[0]), 0.0) ** (4.0 / 3.0)
        return [y[1], -square * math.sin(y[0]) - 2.0 * LAMBDA * y[1] - side * friction * load]

    found, begin, state = np.empty(COUNT), 0.0, np.array([AMPLITUDE, 0.0])
    options = {"rtol": 1e-11, "atol": 1e-12, "dense_output": True, "max_step": 2e-4}
    while begin < times[-1]:
        args = (-math.copysign(1.0, state[0]),)
        # Away from the turning point first, where the velocity is 0 too.
        away = solve_ivp(rates, (begin, begin + 1e-4), state, "DOP853", args=args, **options)
        on = solve_ivp(
            rates, (begin + 1e-4, begin + 0.01), away.y[:, -1], "DOP853", events=turning, args=args, **options
        )
        for part in (away, on):
            inside = (times >= part.t[0]) & (times <= part.t[-1])
            found[inside] = part.sol(times[inside])[0]
        begin, state = on.t[-1], np.array([on.y[0, -1], 0.0])
    return found


@pytest.mark.parametrize("law", [HERTZ, SINE])
def test_the_motion_is_that_of_an_independent_integrator(law):
    assert basis(parameters(law=law))[0] == pytest.approx(independent(law), abs=2e-7)


@pytest.mark.parametrize("law", [HERTZ, SINE])
def test_a_trajectory_knows_its_derivatives_by_the_knots(law):
    found = basis(parameters(law=law))
    # Two rows for each derivative: w's, the amplitude's, then those of the coefficients, in their order.
    first = 6 + 2 * (2 + 3)
    step = 1.0
    for k in range(KNOTS.size):
        moved = KNOTS + step * np.eye(KNOTS.size)[k], KNOTS - step * np.eye(KNOTS.size)[k]
        numeric = (basis(parameters(moved[0], law=law))[0] - basis(parameters(moved[1], law=law))[0]) / (2.0 * step)
        exact = found[first + 2 * k + 2] / (2.0 * math.pi * F_NAT_HZ) ** 2
        # The last knot, beyond which the course stays, has a kink.
        share = 1e-3 if k == KNOTS.size - 1 else 2e-5
        assert exact == pytest.approx(numeric, abs=share * np.abs(numeric).max())


def test_a_frozen_course_gives_the_same_motion_and_derivatives_by_all_else():
    every, frozen = basis(parameters()), basis(parameters(), frozen=True)
    kept = frozen.shape[0]
    assert kept == every.shape[0] - 2 * (3 + KNOTS.size)
    assert frozen[:4] == pytest.approx(every[:4], abs=1e-12)
    assert frozen[4:-1] == pytest.approx(every[4 : kept - 1], abs=1e-9 * np.abs(every[4:kept]).max())


@pytest.mark.parametrize("u", [0.5, 13.0, 40.0, 70.0])
@pytest.mark.parametrize("law", [CONSTANT, HERTZ, SINE])
def test_the_term_knows_its_own_derivatives(u, law):
    function = getattr(torque_course, "py_func", torque_course)
    c = np.array([13.4, law, 0.02, 2e-4, -1e-4, 3e-4, 1e-4, 5e-4])

    def call(c, phi=0.4, u=u):
        grad = np.full(c.size + 1, np.nan)
        out = function(phi, math.sin(phi), math.cos(phi), 0.7, u, c, 0, grad, 1.0, c.size)
        return out, grad[:-1]

    (tau, by_phi, by_v, by_u), grad = call(c)
    step = 1e-6
    assert by_phi == pytest.approx(
        (call(c, phi=0.4 + step)[0][0] - call(c, phi=0.4 - step)[0][0]) / (2 * step), abs=1e-9
    )
    assert by_v == 0.0
    assert by_u == pytest.approx((call(c, u=u + step)[0][0] - call(c, u=u - step)[0][0]) / (2 * step), abs=1e-9)
    for k in (0, *range(2, c.size)):
        moved = step * max(abs(c[k]), 1e-3) * np.eye(c.size)[k]
        numeric = (call(c + moved)[0][0] - call(c - moved)[0][0]) / (2 * moved[k])
        assert grad[k] == pytest.approx(numeric, rel=1e-5, abs=1e-9)
    assert abs(tau) > 1e-5


def test_a_course_without_numbers_writes_nowhere_else():
    function = getattr(torque_course, "py_func", torque_course)
    c = np.array([13.4, 1.0, 0.0, 1e-4, 1e-4])
    grad = np.zeros(c.size + 1)
    tau, *_ = function(0.4, math.sin(0.4), math.cos(0.4), 0.7, math.nan, c, 0, grad, 1.0, c.size)
    assert math.isnan(tau)
