"""Undeclared torques against formulas written here once more, and scipy's DOP853."""

from math import cos, exp, pi, sin, sqrt

import numpy as np
import pytest

from drivers.errors import ConfigError
from drivers.validation import validated
from sim_backend.motion import move
from sim_backend.options import SimulatedOptions
from sim_backend.rest import rest_angle_rad
from sim_backend.rotor import effective
from sim_backend.torque import parameters
from sim_backend.trajectory import states
from tests.sim_backend.bench import options, specimen
from tests.sim_backend.reference import follow

W, LAM, TF = 2 * pi * 215.69, 0.2465, 1324.0
TIMES = np.linspace(0.005, 0.06, 12)
START = (0.41, 30.0)


def effects(*tables):
    return validated(SimulatedOptions, options(undeclared=list(tables)), "backends.simulated").undeclared


def torques(name, *tables, drift_from_s=None):
    """Parameters of a rotor of the same frequency and damping in both variants."""
    q = parameters(effective(specimen(name)), None, effects(*tables), drift_from_s)
    q[0], q[1] = 2 * LAM, W * W
    return q


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
def test_every_torque_is_its_formula_to_1e_11(case, capsys):
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
    with capsys.disabled():
        print(f"\n{case}: {error:.1e} of the amplitude, effect {effect:.1e} rad")
    assert effect > 1e-4
    assert error < 1e-11
