"""Undeclared torques against formulas written here once more, and scipy's DOP853."""

from dataclasses import replace
from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest

from drivers.errors import ConfigError
from drivers.validation import validated
from sim_backend.options import SimulatedOptions
from sim_backend.rotor.dynamics import SingleAxis
from sim_backend.rotor.motion import move
from sim_backend.rotor.rest import rest_angle_rad
from sim_backend.rotor.rotor import FLUCTUATION_WAVES, effective
from sim_backend.rotor.torque import parameters
from sim_backend.rotor.trajectory import states
from tests.kit.rotor_reference import follow
from tests.kit.simulated_bench import options, specimen

W, LAM, TF = 2 * pi * 215.69, 0.2465, 1324.0
TIMES = np.linspace(0.005, 0.06, 12)
START = (0.41, 30.0)


def effects(*tables):
    return validated(SimulatedOptions, options(undeclared=list(tables)), "backends.simulated").hidden_effects


def torques(name, *tables, drift_from_s=None):
    """Parameters of a rotor of the same frequency and damping in both variants."""
    rotor = replace(effective(specimen(name)), f_nat_hz=W / (2 * pi), lambda_per_s=LAM)
    return parameters(rotor, None, effects(*tables), drift_from_s)


def declared(p, v):
    return -2 * LAM * v - W * W * sin(p)


def hertz(p):
    return max(cos(p), 0.0) ** (4 / 3)


def drifting(t, tau):
    since = max(t - 0.02, 0.0)
    f = 215.69 + 3.0 * (tau * (1 - exp(-since / tau)) if tau else since)
    return (2 * pi * f) ** 2


# name: variant, tables, smooth torque(t, phi, phi'), friction(phi, |phi'|) or None
CASES = {
    "coulomb_friction": ("thread", [{"strength": 40.0}], lambda t, p, v: 0.0, lambda p, s: 40.0),
    "hertz_friction": ("thread", [{"strength": 300.0}], lambda t, p, v: 0.0, lambda p, s: 300.0 * hertz(p)),
    "stribeck_friction": (
        "jewel",
        [{"strength": 0.4, "v_s_rad_per_s": 60.0}],
        lambda t, p, v: 0.0,
        lambda p, s: TF * hertz(p) * (1 + 0.4 * exp(-s / 60.0)),
    ),
    "quadratic_drag": ("thread", [{"strength": 3e-3}], lambda t, p, v: 0.0, lambda p, s: 3e-3 * s * s),
    "angle_dependent_damping": ("thread", [{"strength": 2.0}], lambda t, p, v: -4.0 * p * p * v, None),
    "restoring_anharmonicity": (
        "thread",
        [{"strength": 0.05}],
        lambda t, p, v: W * W * sin(p) * 0.05 * (1 - cos(p)),
        None,
    ),
    "torsion_stiffness": ("thread", [{"strength": 0.02}], lambda t, p, v: -0.02 * W * W * p, None),
    "bias_torque": ("thread", [{"strength": 5e3}], lambda t, p, v: 5e3, None),
    "frequency_drift": ("thread", [{"strength": 3.0}], lambda t, p, v: (W * W - drifting(t, 0.0)) * sin(p), None),
    "frequency_drift, settling": (
        "thread",
        [{"strength": 3.0, "tau_s": 0.03}],
        lambda t, p, v: (W * W - drifting(t, 0.03)) * sin(p),
        None,
    ),
}


def tables_of(case):
    return [{"id": case.partition(",")[0], **table} for table in CASES[case][1]]


@pytest.mark.parametrize("case", CASES)
def test_every_torque_is_its_formula_to_1e_11(case):
    variant, _, extra, level = CASES[case]
    dry = level or ((lambda p, s: TF * hertz(p)) if variant == "jewel" else None)

    def rhs(t, y, sign):
        push = declared(y[0], y[1]) + extra(t, y[0], y[1])
        return y[1], push - (sign * dry(y[0], sign * y[1]) if dry else 0.0)

    times = np.unique(np.append(TIMES, 0.02))  # the kink of the drift is at 0.02 s
    wanted = follow(rhs, START, times, turns=dry is not None)
    pieces = move(0.0, times[-1], *START, torques(variant, *tables_of(case), drift_from_s=0.02)).pieces
    plain = move(0.0, times[-1], *START, torques(variant)).pieces
    phi, phi_dot = states(pieces, times)
    error = max(np.abs(phi - wanted[:, 0]).max() / 0.41, np.abs(phi_dot - wanted[:, 1]).max() / (0.41 * W))
    effect = np.abs(states(plain, times)[0] - phi).max()
    print(f"{case}: {error:.1e} of the amplitude, effect {effect:.1e} rad")
    assert effect > 1e-4
    assert error < 1e-11


@pytest.mark.parametrize("case", [c for c in CASES if "drift" not in c and "bias" not in c])
def test_losses_lose_energy_and_conservative_torques_keep_it(case):
    variant, _, _, _ = CASES[case]
    q = torques(variant, *tables_of(case))
    q[0] = 0.0
    beta = 0.05 if "anharmonicity" in case else 0.0
    k = 0.02 if "torsion" in case else 0.0
    phi, phi_dot = states(move(0.0, 0.2, *START, q).pieces, np.linspace(0, 0.2, 500))
    soft = 1 - np.cos(phi) - beta * (1 - np.cos(phi)) ** 2 / 2
    energy = phi_dot**2 / 2 + W * W * (soft + k * phi**2 / 2)
    if beta or k:
        assert energy == pytest.approx(energy[0], rel=1e-12)
    else:
        assert np.all(np.diff(energy) < 1e-9 * energy[0])
        assert energy[-1] < 0.999 * energy[0]


def test_all_torques_at_once_agree_with_the_reference():
    together = [t for c in CASES if "settling" not in c for t in tables_of(c)]

    def rhs(t, y, sign):
        p, v = y
        soft = 1 - 0.05 * (1 - cos(p))
        push = -2 * LAM * v - drifting(t, 0.0) * sin(p) * soft - 0.02 * W * W * p - 4.0 * p * p * v + 5e3
        s = sign * v
        dry = (40.0 + (300.0 + TF) * hertz(p)) * (1 + 0.4 * exp(-s / 60.0))
        return v, push - sign * (dry + 3e-3 * s * s)

    wanted = follow(rhs, START, np.unique(np.append(TIMES, 0.02)), turns=True)[-1]
    ours = move(0.0, TIMES[-1], *START, torques("jewel", *together, drift_from_s=0.02))
    assert [ours.phi_rad, ours.phi_dot_rad_per_s / W] == pytest.approx([wanted[0], wanted[1] / W], abs=1e-12)


def agrees_in_pieces(rotor, fluctuation, rhs):
    """The motion is that of `rhs`, and goes on so where a piece of it begins later."""
    w, wanted = rotor.omega_rad_per_s, follow(rhs, START, TIMES, turns=True)[-1]
    model = SingleAxis(rotor, fluctuation)
    first = model.advance(0.0, 0.025, replace(model.rest(), phi_rad=START[0], phi_dot_rad_per_s=START[1]))
    whole = model.advance(0.025, TIMES[-1], first)
    assert [whole.phi_rad, whole.phi_dot_rad_per_s / w] == pytest.approx([wanted[0], wanted[1] / w], abs=1e-11)
    late = SingleAxis(rotor.later(0.025), fluctuation).advance(0.0, TIMES[-1] - 0.025, first)
    assert late.phi_rad == pytest.approx(whole.phi_rad, abs=1e-12)


def test_friction_that_fluctuates_is_its_formula_also_where_a_piece_of_the_motion_begins_later():
    fluctuation = effects({"id": "friction_fluctuation", "strength": 0.4, "tau_s": 0.02})
    omega, phase = np.linspace(5.0, 400.0, FLUCTUATION_WAVES), np.arange(FLUCTUATION_WAVES)
    rotor = replace(effective(specimen("jewel")), friction_waves=np.column_stack([omega, phase]))
    w = rotor.omega_rad_per_s

    def rhs(t, y, sign):
        x = sqrt(2 / FLUCTUATION_WAVES) * sum(cos(a * t + b) for a, b in zip(omega, phase, strict=True))
        dry = TF * hertz(y[0]) * exp(0.4 * x - 0.08)
        return y[1], -2 * rotor.lambda_per_s * y[1] - w * w * sin(y[0]) - sign * dry

    agrees_in_pieces(rotor, fluctuation, rhs)


def test_a_frequency_that_fluctuates_is_its_formula_also_where_a_piece_of_the_motion_begins_later():
    fluctuation = effects({"id": "frequency_fluctuation", "strength": 0.5, "tau_s": 0.02})
    omega, phase = np.linspace(5.0, 400.0, FLUCTUATION_WAVES), np.arange(FLUCTUATION_WAVES)
    rotor = replace(effective(specimen("jewel")), frequency_waves=np.column_stack([omega, phase]))
    w = rotor.omega_rad_per_s

    def rhs(t, y, sign):
        x = sqrt(2 / FLUCTUATION_WAVES) * sum(cos(a * t + b) for a, b in zip(omega, phase, strict=True))
        now = w + 2 * pi * 0.5 * x
        return y[1], -2 * rotor.lambda_per_s * y[1] - now**2 * sin(y[0]) - sign * TF * hertz(y[0])

    agrees_in_pieces(rotor, fluctuation, rhs)


def test_a_field_breaks_the_rotor_loose_when_it_exceeds_the_static_friction_of_all_laws():
    q = torques("thread", {"id": "coulomb_friction", "strength": 800.0}, *tables_of("stribeck_friction"))
    q[3] = 1e8
    static = 800.0 * 1.4
    sine = np.array([[0.0, 0.99 * static / 1e8, 500.0, -pi / 2, 0.0]])
    assert move(0.0, 0.05, 0.0, 0.0, q, sine).stuck
    sine[0, 1] = 2 * static / 1e8
    free = move(0.0, 0.05, 0.0, 0.0, q, sine)
    assert free.pieces[0, 1] == pytest.approx(np.arcsin(0.5) / 500.0, rel=1e-12)

    def rhs(t, y, sign):
        push = declared(*y) + 2 * static * sin(500.0 * t) * cos(y[0])
        return y[1], push - sign * 800.0 * (1 + 0.4 * exp(-sign * y[1] / 60.0))

    begin = float(free.pieces[0, 1]) + 5e-4
    phi, phi_dot = states(free.pieces, np.array([begin, begin + 5e-4]))
    assert np.all(phi_dot > 0)
    wanted = follow(lambda t, y, sign: rhs(t + begin, y, sign), (phi[0], phi_dot[0]), [5e-4])[-1]
    assert [phi[1], phi_dot[1] / W] == pytest.approx([wanted[0], wanted[1] / W], abs=1e-13)


def test_the_rotor_comes_to_rest_where_dry_friction_holds_it():
    end = move(0.0, 3.0, 0.05, 0.0, torques("thread", {"id": "coulomb_friction", "strength": 2e3}))
    assert end.stuck
    assert W * W * abs(sin(end.phi_rad)) <= 2e3


def test_under_a_bias_torque_the_rotor_rests_at_the_balance_and_an_impossible_one_is_an_error():
    table = {"id": "bias_torque", "strength": 5e3}
    angle = rest_angle_rad(torques("thread", table))
    assert angle == pytest.approx(np.arcsin(5e3 / W**2), rel=1e-12)
    still = move(0.0, 0.1, angle, 0.0, torques("thread", table))
    assert still.phi_rad == pytest.approx(angle, abs=1e-15)
    with pytest.raises(ConfigError, match="bias_torque"):
        rest_angle_rad(torques("thread", {**table, "strength": 1.1 * W**2}))


@pytest.mark.parametrize("case", [c for c in CASES if "stribeck" not in c])
def test_a_strength_of_zero_changes_no_bit(case):
    variant = CASES[case][0]
    tables = [{**t, "strength": 0.0} for t in tables_of(case)]
    none, some = (move(0.0, 0.05, *START, torques(variant, *t)).pieces for t in ([], tables))
    assert np.array_equal(none, some)
