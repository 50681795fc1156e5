import numpy as np
import pytest

from drivers.errors import DeviceError
from sim_backend.rotor.motion import move
from sim_backend.rotor.pieces import ANGLE, LENGTH, SPEED
from sim_backend.rotor.rotor import effective
from sim_backend.rotor.torque import DAMPING, HERTZ, MOMENT, SLOTS, STIFFNESS, field, parameters
from sim_backend.rotor.trajectory import energy_amplitude_rad, largest_angle_rad, states
from tests.kit.rotor_reference import swing
from tests.kit.simulated_bench import CLOCK, specimen

START = {"thread": (0.39, 12.0), "jewel": (0.9, 12.0)}
LATE = {"thread": (0.39, 12.0), "jewel": (0.2, 12.0)}


def signal(phi, phi_dot):
    return np.array([-phi_dot * np.sin(phi), phi_dot * np.cos(phi)])


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def compare(name, seconds, start):
    """Relative rms difference of dm/dt to the reference, and the reference's own difference to rtol 1e-12."""
    rotor = effective(specimen(name))
    times = np.arange(int(seconds * CLOCK.rate_hz)) / CLOCK.rate_hz
    ours = signal(*states(move(0.0, seconds, *start, parameters(rotor)).pieces, times))
    own = {"lam": rotor.lambda_per_s, "w": rotor.omega_rad_per_s, "tf": rotor.tf_over_i_rad_per_s2, "times": times}
    best, worse = (signal(*swing(seconds, *start, **own, rtol=rtol)[:2]) for rtol in (3e-14, 1e-12))
    return rms(ours - best) / rms(best), rms(worse - best) / rms(best)


@pytest.mark.parametrize(("name", "seconds"), [("thread", 0.4), ("jewel", 0.5)])
def test_motion_agrees_with_dop853_with_events_to_1e_9(name, seconds, capsys):
    difference, reference_own = compare(name, seconds, LATE[name])
    with capsys.disabled():
        print(f"\n{name} {seconds} s: ours {difference:.1e}, reference at rtol 1e-12 {reference_own:.1e}")
    assert difference < 1e-9


@pytest.mark.campaign
@pytest.mark.parametrize(("name", "seconds"), [("thread", 15.0), ("jewel", 2.0)])
def test_motion_agrees_with_dop853_over_the_whole_window(name, seconds, capsys):
    difference, reference_own = compare(name, seconds, START[name])
    with capsys.disabled():
        print(f"\n{name} {seconds} s: ours {difference:.1e}, reference at rtol 1e-12 {reference_own:.1e}")
    assert difference < 1e-9


def test_driven_motion_from_rest_with_sticking_agrees_with_the_reference():
    rotor = effective(specimen("jewel"))
    omega, b_v, b_u = 2 * np.pi * 205.0, 60e-6, 25e-6

    def b(t):
        return b_u * np.sin(omega * t), b_v * np.sin(omega * t + 0.4) + 10e-6 * np.exp(-80 * t)

    terms = np.array([
        [b_u, 0, omega, -np.pi / 2, 0], [0, b_v, omega, 0.4 - np.pi / 2, 0], [0, 10e-6, 0, 0, 80.0],
    ])  # fmt: skip
    ours = move(0.0, 0.05, 0.0, 0.0, parameters(rotor), terms)
    _, _, phi, phi_dot = swing(
        0.05, 0.0, 0.0, lam=rotor.lambda_per_s, w=rotor.omega_rad_per_s, tf=rotor.tf_over_i_rad_per_s2,
        m_i=rotor.m_r_am2 / rotor.inertia_kg_m2, b=b, rtol=1e-13,
    )  # fmt: skip
    assert abs(phi) > 0.01
    assert ours.phi_rad == pytest.approx(phi, rel=1e-9)
    assert ours.phi_dot_rad_per_s == pytest.approx(phi_dot, rel=1e-9)


def test_random_drives_between_sticking_and_swinging_agree_with_the_reference():
    rng = np.random.default_rng(4)
    for _ in range(8):
        q = oscillator(damping=5.0, hertz=10 ** rng.uniform(2, 4.5), moment=1e8)
        hold_t = q[HERTZ] / q[MOMENT]
        terms = np.array([
            [hold_t * rng.uniform(-3, 3), hold_t * rng.uniform(-3, 3), 1e3 * rng.uniform(0, 2), rng.uniform(0, 6), rate]
            for rate in (0.0, 150.0)
        ])  # fmt: skip

        def b(t, terms=terms):
            shape = np.cos(terms[:, 2] * t + terms[:, 3]) * np.exp(-terms[:, 4] * t)
            return terms[:, 0] @ shape, terms[:, 1] @ shape

        phi, phi_dot = rng.uniform(-1, 1), rng.choice([0.0, 300.0])
        ours = move(0.0, 0.03, phi, phi_dot, q, terms)
        *_, phi, phi_dot = swing(0.03, phi, phi_dot, lam=2.5, w=1e3, tf=q[HERTZ], m_i=1e8, b=b, rtol=1e-12)
        assert ours.phi_rad == pytest.approx(phi, abs=1e-9)
        assert ours.phi_dot_rad_per_s == pytest.approx(phi_dot, abs=1e-6)


def oscillator(**slots):
    q = np.zeros(SLOTS)
    q[STIFFNESS] = 1e6
    for name, value in slots.items():
        q[{"damping": DAMPING, "hertz": HERTZ, "moment": MOMENT}[name]] = value
    return q


def test_undamped_pendulum_conserves_energy_over_a_thousand_periods():
    end = move(0.0, 6.0, 1.2, 0.0, oscillator())
    assert energy_amplitude_rad(end.phi_rad, end.phi_dot_rad_per_s, 1e3) == pytest.approx(1.2, rel=1e-12)


def test_period_of_a_large_swing_is_the_complete_elliptic_integral():
    from scipy.special import ellipk

    period = 4 * float(ellipk(np.sin(0.75) ** 2)) / 1e3
    end = move(0.0, 50 * period, 1.5, 0.0, oscillator())
    assert end.phi_rad == pytest.approx(1.5, rel=1e-12)
    assert abs(end.phi_dot_rad_per_s) < 1e-7


def test_turning_points_are_pieces_boundaries_with_exactly_zero_speed():
    pieces = move(0.0, 0.05, 0.5, 0.0, oscillator(hertz=2e3)).pieces
    turns = pieces[pieces[:, SPEED] == 0.0]
    assert len(turns) == pytest.approx(0.05 * 1e3 / np.pi, abs=2)
    before = pieces[np.flatnonzero(pieces[:, SPEED] == 0.0)[1:] - 1]
    _, speed = states(before, before[:, 0] + before[:, 1])
    for row in before:
        _, speed = states(row[None, :], np.array([row[0] + row[1]]))
        assert abs(speed[0]) < 1e-12 * 500


def test_pieces_follow_each_other_without_gap():
    for q in (oscillator(hertz=2e3), oscillator(damping=3.0)):
        pieces = move(0.3, 0.35, 0.5, 20.0, q).pieces
        assert pieces[0, 0] == 0.3
        assert pieces[-1, 0] + pieces[-1, 1] == pytest.approx(0.35, abs=1e-15)
        assert pieces[1:, 0] == pytest.approx(pieces[:-1, 0] + pieces[:-1, 1], abs=1e-16)


def test_dry_friction_takes_the_amplitude_down_linearly_and_then_holds_the_rotor():
    end = move(0.0, 0.3, 0.1, 0.0, oscillator(hertz=1e3))
    assert end.stuck
    assert end.phi_dot_rad_per_s == 0.0
    assert 1e6 * abs(np.sin(end.phi_rad)) <= 1e3 * np.cos(end.phi_rad) ** (4 / 3)
    halves = end.pieces[end.pieces[:, SPEED] == 0.0, ANGLE]
    assert np.abs(np.diff(np.abs(halves[:20]))) == pytest.approx(2e-3, rel=0.02)


def test_rotor_at_rest_inside_the_friction_band_never_moves():
    end = move(0.0, 5.0, 0.9e-3, 0.0, oscillator(hertz=1e3))
    assert (end.phi_rad, end.stuck, len(end.pieces)) == (0.9e-3, True, 1)


def test_a_weak_field_leaves_the_rotor_stuck_and_a_stronger_one_releases_it_when_it_exceeds_friction():
    q = oscillator(hertz=1e3, moment=1e8)
    sine = np.array([[0.0, 9.9e-6, 500.0, -np.pi / 2, 0.0]])
    assert move(0.0, 0.05, 0.0, 0.0, q, sine).stuck
    sine[0, 1] = 20e-6
    free = move(0.0, 0.05, 0.0, 0.0, q, sine)
    assert not free.stuck
    assert free.pieces[0, LENGTH] == pytest.approx(np.arcsin(0.5) / 500.0, rel=1e-12)


def test_a_field_that_fades_lets_the_rotor_stick_again():
    q = oscillator(hertz=1e3, moment=1e8)
    end = move(0.0, 0.2, 0.0, 0.0, q, np.array([[0.0, 40e-6, 0.0, 0.0, 200.0]]))
    assert end.stuck
    assert largest_angle_rad(end.pieces) > 1e-3


def test_beyond_ninety_degrees_the_hertz_contact_presses_no_more():
    end = move(0.0, 2e-4, 2.0, 0.0, oscillator(hertz=1e5))
    free = move(0.0, 2e-4, 2.0, 0.0, oscillator())
    assert end.phi_rad == pytest.approx(free.phi_rad, rel=1e-13)
    across = move(0.0, 0.05, 1.9, 0.0, oscillator(hertz=1e4))
    assert largest_angle_rad(across.pieces) == 1.9
    assert np.all(np.isfinite(across.pieces))


def test_field_terms_are_sines_constants_and_dying_exponentials():
    terms = np.array([[1.0, 0.0, 0.0, 0.0, 0.0], [0.0, 2.0, 3.0, -np.pi / 2, 0.0], [5.0, 0.0, 0.0, 0.0, 7.0]])
    assert field(0.2, terms) == pytest.approx((1 + 5 * np.exp(-1.4), 2 * np.sin(0.6)))


def test_absurd_damping_is_an_error_and_not_a_wrong_answer():
    with pytest.raises(DeviceError, match="cannot be followed"):
        move(0.0, 1e-3, 0.1, 0.0, oscillator(damping=1e13))
