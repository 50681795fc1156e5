from dataclasses import replace

import numpy as np
import pytest

from sim_backend.rotor.rigid_body.acceleration import MU, contact, dipole
from sim_backend.rotor.rigid_body.motion import move
from sim_backend.rotor.rigid_body.rest import rest_state, straight
from tests.kit.rigid_rotor_reference import Reference
from tests.kit.rigid_rotors import centre, energy_j, moment, rigid

START = np.array([0.0, 0.0, 0.02, -0.03, 0.6])
DEFECTS = {
    "thread": {"stator_tilt_rad": 0.03, "rotor_tilt_rad": -0.02, "stator_offset_m": [1e-4, 5e-5]},
    "jewel": {"stator_tilt_rad": 0.04, "jewel_tilt_rad": 0.02, "stator_offset_m": [1e-4, 5e-5]},
}


def reference(p):
    return Reference(
        bool(p[0]), p[1], p[2], p[3], p[4], p[5:8], p[8:11], p[11:14], p[14:17], p[17:20],
        friction=(*p[22:26], 0.0, 1.0) if p[22] else None,
    )  # fmt: skip


def start(other):
    """The kernels' state (13,) for the angles of START, n straight up."""
    y = straight()
    rotation = other.rotation(START)
    w = 0.5 * np.sqrt(1 + np.trace(rotation))
    spin = rotation - rotation.T
    y[6:10] = w, spin[2, 1] / (4 * w), spin[0, 2] / (4 * w), spin[1, 0] / (4 * w)
    return y


@pytest.mark.parametrize(
    ("name", "rough", "seconds"),
    [
        pytest.param("thread", 0, 0.01, marks=pytest.mark.long),
        ("jewel", 1, 0.004),
        pytest.param("jewel", 0, 0.02, marks=pytest.mark.campaign),
    ],
)
@pytest.mark.long
def test_the_equations_are_those_of_lagrange_from_energies_alone(name, rough, seconds):
    rotor, p = rigid(name, gravity=[1.0, 4.0, -9.0], defects=DEFECTS[name])
    p[MU] = p[MU] if rough else 0.0
    p[20:22] = 0.0
    field, omega = np.array([2e-4, 5e-4, -1e-4]), 1330.0
    other = replace(reference(p), field=(field, omega))
    terms = np.array([[field[0], field[1], omega, -np.pi / 2, 0.0, field[2]]])
    ours = move(0.0, seconds, start(other), p, rotor.omega_rad_per_s, terms)
    direction, n = other.moved(START, seconds)
    assert moment(ours.internal_state, p) == pytest.approx(direction, abs=2e-7)
    assert ours.internal_state[:3] == pytest.approx(n, abs=2e-7)
    assert np.abs(n[:2]).max() > 1e-3


def test_force_and_field_are_derivatives_of_the_energy_of_two_dipoles():
    _, p = rigid("thread", defects=DEFECTS["thread"])
    other, m = reference(p), np.array([0.011, 0.003, -0.002])
    at = replace(other, body_moment=m, weight=np.zeros(3))
    q, c = np.zeros(5), np.array([2e-4, -3e-4, 4.4e-3])
    found = np.array(dipole(p, *c, *m))
    force = [-at.potential(q, 0.0, c + 1e-30j * e).imag / 1e-30 for e in np.eye(3)]
    field = [-replace(at, body_moment=e).potential(q, 0.0, c) for e in np.eye(3)]
    assert found == pytest.approx([*force, *field], rel=1e-12)


@pytest.mark.parametrize("name", ["thread", "jewel"])
def test_energy_is_kept_for_two_seconds_without_friction_and_damping(name):
    rotor, p = rigid(name, gravity=[3.0, 0.0, -9.0], defects=DEFECTS[name])
    p[20:23] = 0.0
    begin = start(reference(p))
    end = move(0.0, 2.0, begin, p, rotor.omega_rad_per_s).internal_state
    rest = energy_j(rest_state(p, rotor.omega_rad_per_s), p)
    swing = energy_j(begin, p) - rest
    assert swing > 0
    assert energy_j(end, p) - rest == pytest.approx(swing, rel=1e-7)


def test_the_contact_has_the_papers_friction_torque_when_it_only_spins_and_coulombs_force_when_it_only_slides():
    _, p = rigid("jewel")
    load, mu, radius = 0.1, p[22], p[23] * 0.1 ** (1 / 3)
    force, torque = contact(load, 0.0, 1000.0, p)
    assert torque * 1000.0 == pytest.approx(3 * np.pi / 16 * radius * mu * load, rel=1e-9)  # eq:tf
    force, torque = contact(load, 50.0, 0.0, p)
    assert force * 50.0 == pytest.approx(mu * load, rel=1e-6)
    combined = contact(load, 5e-3, 1000.0, p)
    assert combined[0] * 5e-3 < 0.5 * mu * load
    assert combined[1] < contact(load, 0.0, 1000.0, p)[1]
    assert contact(-load, 1.0, 1.0, p) == (0.0, 0.0)


@pytest.mark.parametrize(("name", "wanted_n"), [("jewel", 5.850e-3), ("thread", 6.776e-3)])
def test_the_static_force_across_the_axis_is_that_of_a_tilted_stator(name, wanted_n):
    """Equivalent perpendicular force at 2 deg tilt, 30 deg deflection, design magnets (fig:F_tan_over_epsilon)."""
    plain = {"f_nat_hz": None, "m_r_am2": None}
    rotor, p = rigid(name, measured=plain, defects={"stator_tilt_rad": np.radians(2.0)})
    y = rest_state(p, rotor.omega_rad_per_s)
    c, m = centre(y, p), moment(y, p) * np.linalg.norm(p[14:17])
    axis = p[5:8] - c
    axis /= np.linalg.norm(axis)
    across = np.cross(axis, m)
    m = m * np.cos(np.pi / 6) + across * np.sin(np.pi / 6) + axis * (axis @ m) * (1 - np.cos(np.pi / 6))
    found = np.array(dipole(p, *c, *m))
    towards_centre = axis if name == "jewel" else -axis  # D lies below the jewel's rotor, above the thread's
    about_d = np.cross(m, found[3:]) + p[4] * np.cross(towards_centre, found[:3])
    about_d -= (about_d @ axis) * axis
    assert np.linalg.norm(about_d) / p[4] == pytest.approx(wanted_n, rel=2e-3)
