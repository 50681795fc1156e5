"""Quality factors and envelopes, against theory, against the signal itself, and against the paper's table."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.physics.quality import (
    decay_time_s,
    envelopes,
    equivalent_quality_factor,
    quality_factor,
)
from platform_daemon.estimation.physics.ring_down import RingDown
from tests.kit.paper_parameters import JEWEL_D30, JEWEL_D30_S, JEWEL_N50, N50_S, THREAD_D30, THREAD_D30_S
from tests.kit.small_angle import small_angle_quality_factor


def jewel(public=JEWEL_D30, **changes):
    return RingDown.from_parameters("jewel", {**public, **changes})


def thread(**changes):
    return RingDown.from_parameters("thread", {**THREAD_D30, **changes})


def turning_points(ring_down, seconds, dt=2e-7):
    """(times, |angles|) straight from the signs of the velocity."""
    phi, v = ring_down.motion(round(seconds / dt), dt)
    where = np.flatnonzero(v[1:] * v[:-1] < 0.0)
    return dt * (where + v[where] / (v[where] - v[where + 1])), np.abs(phi[where])


@pytest.mark.parametrize("ring_down", [thread(), jewel()])
def test_the_amplitude_envelope_passes_through_all_turning_points(ring_down):
    times, peaks = turning_points(ring_down, 0.05)
    envelope = envelopes(ring_down, 0.05, 50001)
    assert np.allclose(np.interp(times, envelope.time_s, envelope.amplitude_rad), peaks, rtol=2e-6)
    assert np.all(np.diff(envelope.amplitude_rad) <= 1e-12)


@pytest.mark.parametrize("model", [thread, jewel])
@pytest.mark.parametrize("psi_rad", np.arange(0.0, 2.0 * math.pi, 0.7))
def test_no_amplitude_is_negative_whatever_the_phase(model, psi_rad):
    envelope = envelopes(model(psi_start_rad=psi_rad), 0.3, 51)
    for amplitude in (envelope.amplitude_rad, envelope.v_am2_per_s, envelope.u_am2_per_s):
        assert amplitude.min() >= 0.0
        assert amplitude[0] > 0.0


@pytest.mark.parametrize("ring_down", [thread(), jewel()])
def test_the_signal_envelopes_touch_the_peaks_of_the_signals(ring_down):
    seconds, n = 0.05, 50001
    phi, v = ring_down.motion(n, seconds / (n - 1))
    rate = ring_down.m_r_am2 * ring_down.dynamics.w * v
    envelope = envelopes(ring_down, seconds, n)
    for signal, hull in [(rate * np.cos(phi), envelope.v_am2_per_s), (rate * np.sin(phi), envelope.u_am2_per_s)]:
        assert np.max(np.abs(signal) / hull) == pytest.approx(1.0, abs=6e-4)
        halves = np.array_split(np.abs(signal) / hull, 20)
        assert min(h.max() for h in halves) > 1.0 - 6e-4


@pytest.mark.parametrize("ring_down", [thread(), jewel()])
def test_the_frequency_trace_is_that_of_the_turning_points(ring_down):
    times, _ = turning_points(ring_down, 0.1)
    measured = 1.0 / (times[2:] - times[:-2]) - ring_down.f_nat_hz
    envelope = envelopes(ring_down, 0.1, 20001)
    shift = np.interp(times[1:-1], envelope.time_s, envelope.frequency_shift_hz)
    assert np.allclose(measured, shift, atol=3e-3)


def test_a_stuck_rotor_has_no_envelope_left():
    late = envelopes(jewel(), 3.0, 300)
    stuck = late.time_s > 2.5
    assert np.all(late.v_am2_per_s[stuck] == 0.0)
    assert np.all(late.u_am2_per_s[stuck] == 0.0)
    assert np.all(late.frequency_shift_hz[stuck] == 0.0)


def test_the_jewel_starts_with_the_stronger_signals_of_the_papers_figure():
    # "approximately five times stronger u-signal and three times stronger v-signal": 5.4 and 2.4 follow.
    strong, weak = envelopes(jewel(), 0.01, 10), envelopes(thread(), 0.01, 10)
    assert strong.u_am2_per_s[0] / weak.u_am2_per_s[0] == pytest.approx(5.36, abs=0.05)
    assert strong.v_am2_per_s[0] / weak.v_am2_per_s[0] == pytest.approx(2.43, abs=0.05)


def test_viscous_damping_at_small_angles_has_the_same_quality_factor_over_any_time():
    slow = thread(phi_max_rad=0.01)
    expected = quality_factor(215.69, 0.2465)
    for seconds in (0.24, 4.9, 20.0, math.inf):
        assert equivalent_quality_factor(slow, seconds) == pytest.approx(expected, rel=2e-5)


def test_the_equivalent_quality_factor_solves_its_own_implicit_equation():
    seconds, ring_down = 0.5, jewel()
    q = equivalent_quality_factor(ring_down, seconds)
    envelope = envelopes(ring_down, seconds, 20001)
    area = np.trapezoid(envelope.v_am2_per_s, envelope.time_s)
    peak, w = envelope.v_am2_per_s.max(), ring_down.dynamics.w
    assert q == pytest.approx(area * w / (2 * peak) / (1 - math.exp(-w * seconds / (2 * q))), rel=1e-5)


def test_a_long_window_tends_to_the_infinite_one():
    assert equivalent_quality_factor(jewel(), 30.0) == pytest.approx(equivalent_quality_factor(jewel()), rel=1e-4)


@pytest.mark.parametrize(
    ("degrees", "deviation"), [(1.0, 0.0033), (5.0, -0.0009), (10.0, -0.0024), (23.0, -0.0121), (53.0, -0.0581)]
)
def test_the_closed_form_holds_for_small_angles_and_deviates_as_stated(degrees, deviation):
    angle = math.radians(degrees)
    exact = equivalent_quality_factor(jewel(phi_max_rad=angle, psi_start_rad=0.0))
    closed = small_angle_quality_factor(213.25, 0.0978, 1324.0, angle)
    assert closed / exact - 1.0 == pytest.approx(deviation, abs=5e-4)


def test_the_closed_form_has_both_limits():
    q = quality_factor(213.0, 0.2)
    w = 2 * math.pi * 213.0
    assert small_angle_quality_factor(213.0, 0.2, 0.0, 0.3) == q
    assert small_angle_quality_factor(213.0, 0.2, 1e-9, 0.3) == pytest.approx(q, rel=1e-6)
    dry = math.pi * 0.3 * w * w / (8 * 1000.0)
    for tiny in (0.0, 1e-9, 1e-4):
        assert small_angle_quality_factor(213.0, tiny, 1000.0, 0.3) == pytest.approx(dry, rel=1e-3)
    around = [small_angle_quality_factor(213.0, x, 1000.0, 0.3) for x in (0.000237, 0.000239)]
    assert around[0] == pytest.approx(around[1], rel=1e-6)


def test_no_decay_has_no_equivalent_quality_factor():
    for seconds in (0.5, math.inf):
        with pytest.raises(ValueError, match="does not decay"):
            equivalent_quality_factor(thread(lambda_per_s=-0.2), seconds)
    with pytest.raises(ValueError, match="time span"):
        equivalent_quality_factor(thread(), 0.0)
    with pytest.raises(ValueError, match="m_r"):
        envelopes(RingDown.from_parameters("thread", {k: v for k, v in THREAD_D30.items() if k != "m_r_am2"}), 1.0)


def test_the_papers_thread_figures_reproduce():
    assert quality_factor(215.69, 0.2465) == pytest.approx(2750, abs=2)
    assert decay_time_s(thread()) == pytest.approx(THREAD_D30_S, abs=0.01)


def test_the_papers_jewel_quality_factors_do_not_follow_from_its_mean_parameters():
    """tab:quality_factors prints 1327, 897 and 641, the text T_D30 = 1.28 s. The printed means give what stands here.

    One cause explains all four: an effective friction of 983 rad/s^2 in place of the printed 1324 (74 %) gives 1235,
    949, 629 and 1.31 s, each within 7 %. (Friction scatters by +-353 in the paper, T_D30 by +-0.31 s; and a sign
    softened by tanh brakes less than its parameter says.)
    """
    n50 = jewel(JEWEL_N50)
    assert equivalent_quality_factor(n50, N50_S) == pytest.approx(902, abs=2)  # printed 1327
    assert equivalent_quality_factor(n50) == pytest.approx(496, abs=2)
    d30 = jewel()
    assert equivalent_quality_factor(d30, N50_S) == pytest.approx(949, abs=2)
    assert equivalent_quality_factor(d30, JEWEL_D30_S) == pytest.approx(652, abs=2)  # printed 897
    assert equivalent_quality_factor(d30) == pytest.approx(482, abs=2)  # printed 641
    assert decay_time_s(d30) == pytest.approx(1.003, abs=0.005)  # printed 1.28


def test_one_smaller_friction_explains_the_papers_four_jewel_figures_within_seven_per_cent():
    weaker = jewel(tf_over_i_rad_per_s2=983.0)
    seconds = decay_time_s(weaker)
    assert seconds == pytest.approx(JEWEL_D30_S, rel=0.03)
    assert equivalent_quality_factor(weaker, N50_S) == pytest.approx(1327, rel=0.07)
    assert equivalent_quality_factor(weaker, seconds) == pytest.approx(897, rel=0.07)
    assert equivalent_quality_factor(weaker) == pytest.approx(641, rel=0.07)
