from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from platform_daemon.estimation.physics.rigid_rotor.equations import (
    END,
    FIELD,
    FRICTION,
    INERTIA,
    LANES,
    LINK,
    MASS,
    PULSATION,
    over_tanh,
    slipping_disc,
)
from platform_daemon.estimation.physics.rigid_rotor.implicit_step import disc_slopes
from platform_daemon.estimation.physics.rigid_rotor.motions import EMPTY, motions_beside
from platform_daemon.estimation.physics.rigid_rotor.rotor import (
    CoilDrive,
    LostRotorError,
    NoRestError,
    RigidRotor,
)
from platform_daemon.estimation.physics.rigid_rotor.swing import accelerations, swings
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotor_reference import TINY, Reference, disc_friction
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ = 61035.15625
DRIVE = CoilDrive(field_t=(4e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.3, duration_s=0.03, rx_start_s=0.04)
LOSSES = {"lambda_per_s": 40.0, "side_damping_per_s": 25.0, "lean_damping_per_s": 90.0}
STICKS = {"contact_coupling": 0.0, "creep_m_per_s": 1e-4, "creep_spin_rad_per_s": 20.0}
DEFECTS = {"thread": {"stator_tilt_rad": 0.02, "rotor_tilt_rad": -0.02}, "jewel": {"stator_tilt_rad": 0.03}}


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "rough", "seconds", "losses"),
    [
        ("thread", False, 0.006, {"lambda_per_s": 0.0}),
        ("jewel", True, 0.001, {"lambda_per_s": 0.0}),
        ("thread", False, 0.006, LOSSES | {"damping_axis_to_thread": 0.6}),
        ("jewel", True, 0.001, LOSSES | {"creep_law": 1.0, "creep_spin_rad_per_s": 20.0}),
        ("jewel", True, 0.001, LOSSES | {"creep_law": 0.0, "creep_spin_rad_per_s": 20.0}),
        ("jewel", True, 0.001, LOSSES | {"contact_coupling": 0.0, "creep_spin_rad_per_s": 20.0}),
        ("jewel", True, 0.001, LOSSES | STICKS),
        ("jewel", True, 0.001, LOSSES | {"creep_law": 2.0, "creep_m_per_s": 3e-3}),
        ("jewel", True, 0.001, LOSSES | {"creep_law": 2.0, "creep_m_per_s": 3e-4}),
        ("jewel", True, 0.001, LOSSES | {"creep_law": 3.0, "creep_spin_rad_per_s": 20.0}),
        ("jewel", True, 0.001, LOSSES | {"creep_law": 3.0, "creep_m_per_s": 3e-4}),
        ("jewel", True, 0.001, LOSSES | {"creep_law": 4.0, "creep_m_per_s": 3e-4}),
        ("jewel", True, 0.001, LOSSES | STICKS | {"creep_law": 4.0, "creep_m_per_s": 3e-3}),
        ("jewel", True, 0.001, LOSSES | STICKS | {"creep_law": 4.0, "creep_m_per_s": 3e-4}),
    ],
)
def test_the_motion_is_that_of_lagrange_from_energies_alone(name, rough, seconds, losses):
    ours = true_rotor(rigid_specimen(name, [1.0, 4.0, -9.0], defects=DEFECTS[name]), **losses)
    p, field, omega = ours.parameters, np.array([2e-4, 5e-4, -1e-4]), 1330.0
    tilt = ours.values.bearing_tilt_rad
    body = ours.values.m_r_am2 * np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    other = Reference(
        name == "jewel", p[1], p[2], p[3], p[4], p[5:8], p[8:11], p[11:14], body, p[15:18],
        friction=tuple(p[[20, 21, 22, 23, 24, 28]]) if rough else None, damping=tuple(p[[18, 19, 25, 26]]),
        field=(field, omega),
    )  # fmt: skip
    start = np.array([0.0, 0.0, 0.02, -0.03, 0.6])
    end = solve_ivp(
        lambda t, y: np.concatenate([y[5:], other.acceleration(t, y[:5], y[5:])]),
        (0.0, seconds), np.concatenate([start, np.zeros(5)]), method="DOP853", rtol=1e-9, atol=1e-10,
    ).y[:, -1]  # fmt: skip
    rate = sum(end[5 + k] * other.moment(end[:5] + TINY * 1j * np.eye(5)[k]).imag / TINY for k in range(5))
    y, drive, out = np.zeros(13), np.zeros(7), np.zeros((LANES, 1, 3))
    y[4:7] = other.moment(start) / ours.values.m_r_am2
    y[7:10] = other.rotation(start)[:, 2] if name == "thread" else 0.0
    drive[FIELD : FIELD + 3], drive[PULSATION], drive[END] = field, omega, seconds
    in_lanes = [np.stack([each] * LANES, axis=1) for each in (y, p, field)]
    swings(
        *in_lanes,
        drive,
        np.full(LANES, seconds),
        1.0,
        ours.tolerances(),
        EMPTY,
        np.array([np.inf, 0.0, 0.0, 0.0]),
        ours.sticks,
        out,
    )
    assert out[0, 0] * ours.values.m_r_am2 == pytest.approx(rate, abs=1e-6 * np.linalg.norm(rate))


def test_a_rotor_at_rest_in_its_own_tilted_place_stays_there():
    specimen = rigid_specimen("jewel", [3.0, 0.0, -9.0], defects={"jewel_tilt_rad": 0.05})
    still = replace(DRIVE, field_t=(0.0, 0.0, 0.0))
    rotor = true_rotor(specimen, still)
    assert np.abs(rotor.rest()[:2]).max() > 1e-3
    assert np.abs(rotor.dm_dt(200, 2000.0)[0]).max() < 1e-6  # a shot has noise of 1e-2


@pytest.mark.parametrize("contact", [{}, STICKS])
def test_neighbours_at_the_same_steps_differ_smoothly(contact):
    """Central differences of two sizes agree to their order, which noise of the choice of steps would hide."""
    specimen = rigid_specimen("jewel", [0.0, 0.0, -9.81], 2.0, defects={"stator_tilt_rad": 0.03})
    rotor = true_rotor(specimen, DRIVE, **contact)
    assert rotor.sticks == bool(contact)
    _, steps = rotor.dm_dt(1000, RATE_HZ)

    def slope(h):
        pair = [RigidRotor(rotor.geometry, replace(rotor.values, stator_tilt_rad=0.03 + s * h), DRIVE) for s in (-1, 1)]
        (low, high), _ = motions_beside(pair, 1000, RATE_HZ, steps, near=rotor)
        return (high - low) / (2 * h)

    coarse, fine = slope(1e-5), slope(1e-6)
    assert np.abs(coarse - fine).max() < 1e-4 * np.abs(fine).max()


def test_a_contact_that_sticks_moves_alike_with_steps_of_either_kind(monkeypatch):
    specimen = rigid_specimen("jewel", [0.0, 0.0, -9.81], 2.0, defects={"stator_tilt_rad": 0.03})
    rotor = true_rotor(specimen, DRIVE, **STICKS | {"creep_m_per_s": 3e-4})
    implicit, steps = rotor.dm_dt(4000, RATE_HZ)
    monkeypatch.setattr(RigidRotor, "sticks", False)
    explicit, more = rotor.dm_dt(4000, RATE_HZ)
    assert np.abs(implicit - explicit).max() < 2e-6 * np.abs(explicit).max()
    assert more.size > 5 * steps.size


@pytest.mark.parametrize("name", ["thread", "jewel"])
def test_rotors_beside_each_other_are_those_alone(name):
    """Each with its own start, parameters, field and first sample."""
    rotor = true_rotor(rigid_specimen(name, [2.0, 1.0, -9.0], defects={"stator_tilt_rad": 0.03}), DRIVE)
    numbers = [{"f_nat_hz": 214.0}, {"drive_size": 0.97, "turn_u_rad": 0.01, "drive_delay_s": 3e-6}]
    changed = [RigidRotor(rotor.geometry, rotor.values.with_numbers(each), DRIVE) for each in numbers]
    together, _ = motions_beside(changed, 500, RATE_HZ)
    for one, found in zip(changed, together, strict=True):
        alone, _ = one.dm_dt(500, RATE_HZ)
        assert np.abs(found - alone).max() < 1e-6 * np.abs(alone).max()
    assert np.abs(together[0] - together[1]).max() > 1e-3 * np.abs(together[0]).max()


@pytest.mark.parametrize("contact", [{}, STICKS])
def test_one_motion_is_sampled_once_more_at_later_times(contact):
    rotor = true_rotor(rigid_specimen("jewel", defects={"stator_tilt_rad": 0.03}), DRIVE, **contact)
    neighbour = replace(rotor, values=replace(rotor.values, f_nat_hz=214.0))
    _, (beside, *late), _ = rotor.dm_dt_beside([neighbour], 500, RATE_HZ, late_s=[1e-5, 1.0 / RATE_HZ])
    whole, _ = rotor.dm_dt(501, RATE_HZ)
    delayed, _ = replace(rotor, values=replace(rotor.values, drive_delay_s=1e-5)).dm_dt(500, RATE_HZ)
    size = np.abs(whole).max()
    assert np.abs(late[0] - delayed).max() < 1e-6 * size
    assert np.abs(late[1] - whole[:, 1:]).max() < 1e-6 * size
    assert np.abs(beside - whole[:, :-1]).max() > 1e-3 * size


def test_contact_radius_and_distance_follow_from_what_is_measured():
    rotor = true_rotor(rigid_specimen("jewel"))
    v = rotor.values
    assert rotor.geometry.distance_m(v.f_nat_hz, v.m_r_am2) == pytest.approx(4.622e-3, abs=2e-6)
    assert rotor.stator_moment_am2 == pytest.approx(rotor.geometry.stator_moment_am2, rel=1e-9)
    assert rotor.contact_radius_m == pytest.approx(11.9e-6, rel=0.01)


def test_a_rotor_that_balances_nowhere_and_one_that_cannot_be_followed_say_so():
    rotor = true_rotor(rigid_specimen("jewel"), DRIVE)
    with pytest.raises(NoRestError, match="balance nowhere"):
        RigidRotor(rotor.geometry, replace(rotor.values, stator_tilt_rad=1.5), DRIVE).rest()
    with pytest.raises(LostRotorError, match="cannot be followed"):
        RigidRotor(rotor.geometry, replace(rotor.values, lambda_per_s=1e30), DRIVE).dm_dt(10, RATE_HZ)


@pytest.mark.parametrize("slip_share", [0.0, 1e-3])
def test_a_disc_whose_points_creep_by_themselves_spins_and_slips_as_the_integral_over_it(slip_share):
    """Of Coulomb's friction v / sqrt(v^2 + c^2) under Hertz's pressure, beside a slow slip or none."""
    creep = 1e-3
    rotor = true_rotor(rigid_specimen("jewel", [0.0, 0.0, 0.0], 2.0), creep_law=2.0, creep_m_per_s=creep)
    p = rotor.parameters
    for speed in (0.1, 1.0, 3.0, 20.0):  # of the disc's edge, over the creep
        y = rotor.rest()
        spin, slip = speed * creep / rotor.contact_radius_m, slip_share * creep
        y[12], y[2] = spin, slip / p[LINK]
        smooth = p.copy()
        smooth[FRICTION] = 0.0
        rough, free = (
            accelerations(np.repeat(y[:, None], LANES, 1), np.repeat(q[:, None], LANES, 1)) for q in (p, smooth)
        )
        change = (rough - free)[:, 0]
        most = rotor.values.friction_coefficient * rotor.geometry.pull_n(rotor.values.f_nat_hz, rotor.values.distance_m)
        torque = 3.0 * quad(lambda x, u=speed: x**3 * u * np.sqrt(1 - x * x) / np.hypot(u * x, 1.0), 0, 1)[0]
        assert -change[12] * p[INERTIA] == pytest.approx(most * rotor.contact_radius_m * torque, rel=3e-3)
        if slip:
            force = (
                3.0
                * quad(
                    lambda x, u=speed: x * np.sqrt(1 - x * x) / np.hypot(u * x, 1) * (1 - 0.5 / (1 + 1 / (u * x) ** 2)),
                    0,
                    1,
                )[0]
            )
            assert -change[2] * p[LINK] * p[MASS] == pytest.approx(most * slip_share * force, rel=3e-3)


@pytest.mark.parametrize("k", [0.2, 0.5, 0.9, 1.1, 1.5, 4.0, 50.0])
def test_a_disc_with_coulombs_friction_slips_and_spins_as_the_integral_over_it(k):
    rotor = true_rotor(rigid_specimen("jewel", [0.0, 0.0, 0.0], 2.0), creep_law=3.0, creep_m_per_s=0.0)
    p, y = rotor.parameters, rotor.rest()
    slip = 0.02
    spin = slip / (k * rotor.contact_radius_m)
    y[12], y[2] = spin, slip / p[LINK]
    smooth = p.copy()
    smooth[FRICTION] = 0.0
    rough, free = (accelerations(np.repeat(y[:, None], LANES, 1), np.repeat(q[:, None], LANES, 1)) for q in (p, smooth))
    change = (rough - free)[:, 0]
    pull = rotor.geometry.pull_n(rotor.values.f_nat_hz, rotor.values.distance_m)
    load = pull + p[MASS] * slip**2 / p[LINK]
    most, radius = rotor.values.friction_coefficient * load, rotor.contact_radius_m * (load / pull) ** (1 / 3)
    force, torque = disc_friction(slip / (spin * radius))
    assert -change[2] * p[LINK] * p[MASS] == pytest.approx(most * force, rel=3e-4)
    assert -change[12] * p[INERTIA] == pytest.approx(most * radius * torque, rel=3e-4)


@pytest.mark.parametrize("k", [0.02, 0.5, 0.999, 1.001, 1.2, 4.0, 60.0])
def test_the_slopes_of_a_discs_friction_are_those_of_its_values(k):
    step = 1e-6 * k
    above, below = slipping_disc(k + step), slipping_disc(k - step)
    numeric = [(a - b) / (2.0 * step) for a, b in zip(above, below, strict=True)]
    assert disc_slopes(k) == pytest.approx(numeric, rel=0.1)  # an implicit step needs no more


@pytest.mark.parametrize("x", [1e-9, 1e-3, 0.3, 1.0, 5.0, 20.0, 30.0, 1e30])
def test_the_tangent_by_which_a_contact_creeps(x):
    assert over_tanh(x) == pytest.approx(1.0 / np.tanh(x), rel=2e-9)


@pytest.mark.parametrize(("law", "coupling"), [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (3.0, 1.0), (4.0, 1.0), (4.0, 0.0)])
def test_a_contact_without_a_radius_has_rates(law, coupling):
    contact = {"creep_law": law, "contact_coupling": coupling, "creep_m_per_s": 1e-6}
    rotor = true_rotor(rigid_specimen("jewel", [0.0, 0.0, -9.81], 2.0), DRIVE, **contact)
    bare = RigidRotor(rotor.geometry, replace(rotor.values, tf_over_i_rad_per_s2=0.0), DRIVE)
    assert bare.sticks
    assert np.all(np.isfinite(bare.dm_dt(100, RATE_HZ)[0]))
