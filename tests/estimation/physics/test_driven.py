"""Planned zeros of a field against an integrator that shares nothing with them."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from platform_daemon.estimation.physics.driven import DrivenModel, NoPlanError, plan_for_all, plan_phase
from platform_daemon.estimation.physics.models import model_named

W, LAMBDA = 2 * math.pi * 212.0, 0.25
PUSH = 11e-3 / 9.92e-11 * 100e-6


def driven(push=(PUSH, 0.0), model="thread", values=(LAMBDA,), **keys):
    return DrivenModel(model_named(model), W, values, push, **keys)


def turns(plan, push, tx_s, start=(0.0, 0.0), friction=0.0):
    """Turning points (time, angle) of the motion under the planned sines."""
    zeros, sign = plan.zeros_s, plan.first_sign

    def field(t):
        k = int(np.searchsorted(zeros, t, side="right")) - 1
        if not 0 <= k < len(zeros) - 1:
            return 0.0
        return sign * (-1) ** k * math.sin(math.pi * (t - zeros[k]) / (zeros[k + 1] - zeros[k]))

    def slope(t, y):
        held = friction * max(math.cos(y[0]), 0.0) ** (4 / 3) * math.tanh(y[1] / (1e-4 * W))
        pushed = field(t) * (push[0] * math.cos(y[0]) - push[1] * math.sin(y[0]))
        return [y[1], -2 * LAMBDA * y[1] - W**2 * math.sin(y[0]) - held + pushed]

    def turn(t, y):
        return y[1]

    found = solve_ivp(slope, (0, tx_s), start, "DOP853", events=turn, rtol=1e-9, atol=1e-12, max_step=1 / 212 / 20)
    inside = found.t_events[0] > 0.3 * math.pi / W
    return found.t_events[0][inside], np.abs(found.y_events[0][inside, 0])


@pytest.mark.parametrize("push", [(PUSH, 0.0), (-PUSH, 0.5 * PUSH), (0.7 * PUSH, -0.7 * PUSH)])
@pytest.mark.parametrize("start", [(0.0, 0.0), (0.1, -60.0), (-0.05, 80.0), (0.2, 0.0)])
def test_field_and_velocity_change_their_sign_together(push, start):
    tx_s = 20 / 212.0
    plan = plan_phase(driven(push), tx_s, start)
    times, angles = turns(plan, push, tx_s, start)
    n = min(len(times), len(plan.zeros_s) - 1)
    assert n >= 37
    assert np.max(np.abs(times[:n] - plan.zeros_s[1 : n + 1])) < 2e-4 / 212
    assert np.max(np.abs(angles[:n] - plan.deflection_rad[:n])) < 2e-4
    assert np.all(np.diff(angles) > 0)


def test_dry_friction_is_part_of_the_plan():
    plan = plan_phase(driven(model="jewel", values=(LAMBDA, 1300.0)), 0.1)
    times, angles = turns(plan, (PUSH, 0.0), 0.1, friction=1300.0)
    assert angles[-1] == pytest.approx(plan.deflection_rad[len(times) - 1], rel=1e-3)
    assert plan.deflection_rad[-2] < plan_phase(driven(), 0.1).deflection_rad[-2]


def test_the_frequency_of_the_field_falls_with_the_amplitude():
    plan = plan_phase(driven(), 0.15)
    f = 0.5 / np.diff(plan.zeros_s)
    assert np.all(np.diff(f) < 1e-3)
    assert f[-1] == pytest.approx(212.0 * (1 - plan.deflection_rad[-1] ** 2 / 16), rel=2e-3)


@pytest.mark.parametrize(
    ("model", "word"),
    [
        (driven((0.0, PUSH)), "hardly along v"),
        (driven((100 * PUSH, 0.0)), "."),
        (driven((1.0, 0.0), "jewel", (LAMBDA, 1300.0)), "hardly moves"),
    ],
)
def test_what_does_not_swing_or_swings_too_far_has_no_plan(model, word):
    with pytest.raises(NoPlanError, match=word):
        plan_phase(model, 0.1)


def test_a_plan_with_a_tolerance_holds_where_the_plain_one_falls_out_of_step():
    """At 120 periods an f_nat 0.3 % above the one believed leaves the plain plan behind."""
    model = driven((0.5 * PUSH, 0.0))
    truths = [DrivenModel(model.model, W * (1 + x), (LAMBDA,), model.push) for x in (-0.003, 0.0, 0.003)]
    worst = {}
    for tolerance in (0.0, 0.003):
        plan = plan_for_all(model, 120 / 212.0, tolerance)
        worst[tolerance] = min(truth.reached_rad(plan.zeros_s, plan.first_sign) for truth in truths)
    assert worst[0.003] > 1.3 * worst[0.0]


def test_what_a_field_reaches_is_what_an_integrator_says():
    plan = plan_phase(driven(), 0.1)
    *_, reached = plan.deflection_rad
    assert driven().reached_rad(plan.zeros_s, plan.first_sign) == pytest.approx(reached, abs=1e-6)
