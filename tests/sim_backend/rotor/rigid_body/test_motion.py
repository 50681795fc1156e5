import numpy as np
import pytest

from drivers.errors import DeviceError
from sim_backend.rotor import motion as single
from sim_backend.rotor.rigid_body.motion import RIGID_PIECE_SLOTS, move
from sim_backend.rotor.rigid_body.rest import moved, rest_state, straight
from sim_backend.rotor.torque import parameters
from sim_backend.rotor.trajectory import states
from tests.kit.rigid_rotors import moment, rigid

TX_S = 2879 * 2048 / 125e6


def swung(p, phi_rad):
    return moved(straight(), np.array([0.0, 0.0, 0.0, 0.0, phi_rad]))


def side_swing(rotor, p, y, seconds):
    """Largest component of the moment along w in the last tenth of a free swing."""
    y = move(0.0, 0.9 * seconds, y, p, rotor.omega_rad_per_s).internal_state
    peak = 0.0
    for _ in range(100):
        y = move(0.0, seconds / 1000, y, p, rotor.omega_rad_per_s).internal_state
        peak = max(peak, abs(moment(y, p)[2]))
    return peak


@pytest.mark.parametrize(("name", "seconds"), [("thread", 3.0), ("jewel", 2.0)])
def test_without_defects_a_free_swing_is_that_of_the_single_axis_rotor(name, seconds):
    rotor, p = rigid(name)
    start = single.move(0.0, TX_S, 0.0, 0.0, parameters(rotor), np.array([[2e-5, 4e-4, 1330.0, -np.pi / 2, 0.0]]))
    y = swung(p, start.phi_rad)
    y[12] = start.phi_dot_rad_per_s
    free = single.move(TX_S, seconds, start.phi_rad, start.phi_dot_rad_per_s, parameters(rotor))
    ours = move(TX_S, seconds, y, p, rotor.omega_rad_per_s)
    times = np.linspace(TX_S, seconds, 40_000)
    (phi, speed), (wanted, wanted_speed) = states(ours.pieces, times), states(free.pieces, times)
    assert np.abs(phi - wanted).max() < 1e-6 * np.abs(wanted).max()
    assert np.abs(speed - wanted_speed).max() < 1e-6 * np.abs(wanted_speed).max()
    assert ours.stuck is free.stuck


@pytest.mark.parametrize("name", ["thread", "jewel"])
def test_a_drive_across_the_axis_moves_it_as_the_single_axis_rotor(name):
    rotor, p = rigid(name)
    field = np.array([[2e-5, 4e-4, 1330.0, -np.pi / 2, 0.0, 0.0]])
    one = single.move(0.0, TX_S, 0.0, 0.0, parameters(rotor), field[:, :5])
    five = move(0.0, TX_S, straight(), p, rotor.omega_rad_per_s, field)
    assert five.phi_rad == pytest.approx(one.phi_rad, abs=1e-6)
    assert five.phi_dot_rad_per_s == pytest.approx(one.phi_dot_rad_per_s, abs=1e-6 * rotor.omega_rad_per_s)
    assert np.abs(five.internal_state[:2]).max() < 1e-12


def test_pieces_hold_the_moments_motion_in_all_three_axes():
    rotor, p = rigid("thread", defects={"stator_tilt_rad": 0.05})
    y = moved(rest_state(p, rotor.omega_rad_per_s), np.array([0.01, 0.01, 0.1, -0.1, 0.4]))
    found = move(0.0, 0.01, y, p, rotor.omega_rad_per_s)
    assert found.pieces.shape[1] == RIGID_PIECE_SLOTS
    total = np.zeros(3)
    powers = 2.0 / np.arange(1, 9) * (np.arange(8) % 2 == 0)  # integral of x^k over -1 ... 1
    for row in found.pieces:
        total += 0.5 * row[1] * row[12:].reshape(3, 8) @ powers
    assert moment(y, p) + total == pytest.approx(moment(found.internal_state, p), abs=1e-9)


def test_the_thread_is_unstable_in_large_swings_a_tiny_seed_grows_without_any_defect():
    rotor, p = rigid("thread")
    p[20] = 0.0
    seed = np.array([1e-7, 1e-7, 1e-7, 1e-7, 0.0])
    large, small = (side_swing(rotor, p, moved(swung(p, phi), seed), 0.5) for phi in (0.45, 0.1))
    assert large > 1e-4
    assert small < 1e-5


def test_the_jewel_has_no_such_instability():
    rotor, p = rigid("jewel")
    p[20:23] = 0.0, 0.0, p[22]
    seed = np.array([1e-6, 1e-6, 0.0, 0.0, 0.0])
    assert side_swing(rotor, p, moved(swung(p, 0.9), seed), 0.5) < 1e-5


def test_friction_stops_the_jewel_and_holds_it():
    rotor, p = rigid("jewel")
    end = move(0.0, 0.3, swung(p, 0.1), p, rotor.omega_rad_per_s)
    assert end.stuck
    assert abs(end.phi_rad) <= rotor.tf_over_i_rad_per_s2 / rotor.omega_rad_per_s**2
    again = move(0.0, 5.0, end.internal_state, p, rotor.omega_rad_per_s)
    assert again.phi_rad == pytest.approx(end.phi_rad, abs=1e-8)
    assert len(again.pieces) < 20


def test_a_motion_can_be_cut_and_goes_on():
    rotor, p = rigid("jewel", defects={"stator_tilt_rad": 0.03}, side=2.0)
    y = moved(rest_state(p, rotor.omega_rad_per_s), np.array([0, 0, 0, 0, 0.9]))
    whole = move(0.0, 0.05, y, p, rotor.omega_rad_per_s)
    half = move(0.0, 0.0233, y, p, rotor.omega_rad_per_s)
    rest = move(0.0233, 0.05, half.internal_state, p, rotor.omega_rad_per_s)
    assert rest.internal_state == pytest.approx(whole.internal_state, abs=1e-4)
    assert rest.phi_rad == pytest.approx(whole.phi_rad, abs=1e-7)


def test_nonsense_is_refused_in_words():
    rotor, p = rigid("thread")
    p[21] = 1e30
    with pytest.raises(DeviceError, match="cannot be followed"):
        move(0.0, 0.1, moved(straight(), np.full(5, 0.1)), p, rotor.omega_rad_per_s)
