"""Torques with a state of their own against formulas written here once more, and scipy's integrators."""

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest

from drivers.validation import validated
from sim_backend.options import SimulatedOptions
from sim_backend.rotor.internal_state import SECOND, STATES, STRETCH, relaxed
from sim_backend.rotor.motion import move
from sim_backend.rotor.rotor import effective
from sim_backend.rotor.torque import parameters
from sim_backend.rotor.trajectory import states
from tests.kit.rotor_reference import follow
from tests.kit.simulated_bench import options, specimen

W, LAM, TF = 2 * pi * 215.69, 0.2465, 1324.0
TIMES = np.linspace(0.005, 0.06, 12)
START = (0.41, 30.0)
K, TAU, REACH, A = 0.03, 0.02, 0.15, 400.0
GAP, GAP_W, GAP_G = 0.004, 2 * pi * 900.0, 25.0
C, MODE_HZ, MODE_G = 0.01, 212.0, 4.0


def maxwell(t, y, sign):
    return -y[2], [K * W * W * y[1] - y[2] / TAU]


def dahl(t, y, sign):
    return -A * y[2] / REACH, [y[1] - sign * y[1] * y[2] / REACH]


def creeping(t, y, sign):
    return -K * W * W * y[2] * y[0], [2 * y[0] * y[1] - y[2] / TAU]


def breathing(t, y, sign):
    pull = GAP * (1 - cos(y[0]) / (1 + y[2]) ** 4) - y[2]
    return W * W * sin(y[0]) * (1 - 1 / (1 + y[2]) ** 3), [y[3], GAP_W**2 * pull - 2 * GAP_G * y[3]]


def second(order):
    def rates(t, y, sign):
        own = C * W * W * y[0] ** order / order - (2 * pi * MODE_HZ * order) ** 2 * y[2] - 2 * MODE_G * y[3]
        return C * W * W * y[2] * y[0] ** (order - 1), [y[3], own]

    return rates


MODE = {"decay_per_s": MODE_G}
CASES = {
    "memory_relaxation": ({"strength": K, "tau_s": TAU}, maxwell, 1),
    "memory_bristle": ({"strength": A, "reach_rad": REACH}, dahl, 1),
    "memory_amplitude": ({"strength": K, "tau_s": TAU}, creeping, 1),
    "breathing_gap": ({"strength": GAP, "frequency_hz": GAP_W / (2 * pi), "decay_per_s": GAP_G}, breathing, 2),
    "second_mode, 1": ({"strength": C, **MODE, "frequency_hz": MODE_HZ, "order": 1}, second(1), 2),
    "second_mode, 2": ({"strength": C, **MODE, "frequency_hz": 2 * MODE_HZ, "order": 2}, second(2), 2),
}


def torques(variant, *tables):
    found = validated(SimulatedOptions, options(undeclared=list(tables)), "backends.simulated").hidden_effects
    rotor = replace(effective(specimen(variant)), f_nat_hz=W / (2 * pi), lambda_per_s=LAM)
    return parameters(rotor, hidden_effects=found)


def table_of(case):
    return {"id": case.partition(",")[0], **CASES[case][0]}


@pytest.mark.parametrize("variant", ["thread", "jewel"])
@pytest.mark.parametrize("case", CASES)
def test_every_torque_with_an_internal_state_is_its_formula_to_1e_11(case, variant):
    _, extra, states_of_its_own = CASES[case]

    def rhs(t, y, sign):
        push, own = extra(t, y, sign)
        friction = TF * max(cos(y[0]), 0.0) ** (4 / 3) if variant == "jewel" else 0.0
        return [y[1], -2 * LAM * y[1] - W * W * sin(y[0]) + push - sign * friction, *own]

    y = [*START, *([0.0] * states_of_its_own)]
    wanted = follow(rhs, y, TIMES, turns=variant == "jewel" or "bristle" in case)
    ours = move(0.0, TIMES[-1], *START, torques(variant, table_of(case)))
    phi, phi_dot = states(ours.pieces, TIMES)
    error = max(np.abs(phi - wanted[:, 0]).max() / 0.41, np.abs(phi_dot - wanted[:, 1]).max() / (0.41 * W))
    effect = np.abs(states(move(0.0, TIMES[-1], *START, torques(variant)).pieces, TIMES)[0] - phi).max()
    print(f"{variant} {case}: {error:.1e} of the amplitude, effect {effect:.1e} rad")
    assert effect > 1e-4
    assert error < 1e-11
    assert ours.internal_state.shape == (STATES,)


def stored_energy(case, z):
    """Energy in the internal state, such that it and the rotor's together can only fall."""
    if case == "memory_relaxation":
        return z[0] ** 2 / (2 * K * W**2)
    if case == "memory_bristle":
        return A * z[1] ** 2 / (2 * REACH)
    if case == "memory_amplitude":
        return K * W**2 * z[2] ** 2 / 4
    return None


def energy(phi, phi_dot):
    return phi_dot**2 / 2 + W * W * (1 - cos(phi))


@pytest.mark.parametrize("case", [c for c in CASES if "memory" in c])
def test_a_memory_torque_never_gives_more_energy_than_it_took(case):
    q = torques("thread", table_of(case))
    q[0] = 0.0
    seen, at = [], (*START, None)
    for _ in range(400):
        end = move(0.0, 5e-4, at[0], at[1], q, internal_state=at[2])
        at = (end.phi_rad, end.phi_dot_rad_per_s, end.internal_state)
        seen.append(energy(end.phi_rad, end.phi_dot_rad_per_s) + stored_energy(case, end.internal_state))
    assert np.all(np.diff(seen) < 1e-12 * seen[0])
    assert seen[-1] < 0.999 * seen[0]


def test_gap_and_second_mode_only_exchange_energy_with_the_rotor():
    for case in ("breathing_gap", "second_mode, 1", "second_mode, 2"):
        q = torques("thread", {**table_of(case), "decay_per_s": 0.0})
        q[0] = 0.0
        totals, own = [], []
        at = (*START, None)
        for _ in range(100):
            end = move(0.0, 7e-4, at[0], at[1], q, internal_state=at[2])
            at = (end.phi_rad, end.phi_dot_rad_per_s, end.internal_state)
            p, (x, v, y, y_dot) = end.phi_rad, end.internal_state[STRETCH : SECOND + 2]
            inertia = 3 * W**2 / (GAP * GAP_W**2)
            gap = inertia * (v**2 + (GAP_W * x) ** 2) / 2 - 3 * W**2 * x + W**2 * (1 - (1 + x) ** -3.0) * cos(p)
            order = 2 if case.endswith("2") else 1
            mode = (y_dot**2 + (2 * pi * MODE_HZ * order * y) ** 2) / 2 - C * W**2 * y * p**order / order
            own.append(gap if "gap" in case else mode)
            totals.append(energy(p, end.phi_dot_rad_per_s) + own[-1])
        assert np.array(totals) == pytest.approx(totals[0], rel=1e-12)
        assert np.ptp(own) > 1e-6 * totals[0]


def test_a_second_mode_beats():
    q = torques("thread", {**table_of("second_mode, 1"), "decay_per_s": 0.0})
    phi, phi_dot = states(move(0.0, 1.0, *START, q).pieces, np.linspace(0, 1, 3000))
    energies = phi_dot**2 / 2 + W * W * (1 - np.cos(phi))
    assert energies.min() < 0.8 * energies.max()
    assert energies[1500:].max() > 0.9 * energies[0] * np.exp(-2 * LAM)


def test_a_stuck_rotor_is_shaken_loose_by_its_second_mode():
    q = torques("jewel", table_of("second_mode, 1"))
    state = relaxed(q)
    state[SECOND] = 2 * TF / (C * W * W)
    end = move(0.0, 0.02, 0.0, 0.0, q, internal_state=state)
    assert np.abs(end.pieces[:, 2]).max() > 1e-4
    state[SECOND] = 0.9 * TF / (C * W * W)
    end = move(0.0, 0.02, 0.0, 0.0, q, internal_state=state)
    assert end.stuck
    t, w = 0.02, np.sqrt((2 * pi * MODE_HZ) ** 2 - MODE_G**2)
    free = state[SECOND] * np.exp(-MODE_G * t) * (cos(w * t) + MODE_G / w * sin(w * t))
    assert end.internal_state[SECOND] == pytest.approx(free, rel=1e-9)


def test_a_stretch_may_be_cut_anywhere():
    q = torques("jewel", *(table_of(c) for c in CASES if "2" not in c))
    whole = move(0.0, 0.05, *START, q)
    first = move(0.0, 0.0233, *START, q)
    rest = move(0.0233, 0.05, first.phi_rad, first.phi_dot_rad_per_s, q, internal_state=first.internal_state)
    assert rest.phi_rad == pytest.approx(whole.phi_rad, abs=1e-12)
    assert rest.internal_state == pytest.approx(whole.internal_state, rel=1e-9)
