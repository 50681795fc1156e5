"""What tune computes, against the motion integrated step by step."""

import math

import numpy as np
import pytest

from platform_daemon.core.settings import load_specimen
from platform_daemon.features.acquire.settling import remaining_amplitude, time_until
from platform_daemon.features.tune import numbers

OMEGA = 2 * math.pi * 213.0


def driven(drive: float, periods: int, f_tx_hz: float, omega: float, sine=lambda x: x) -> float:
    """Amplitude after a burst, rad: leapfrog of phi'' = -omega^2 sin(phi) + drive sin(omega_tx t)."""
    dt = 1e-6
    time = np.arange(round(periods / f_tx_hz / dt)) * dt
    push = drive * np.sin(2 * math.pi * f_tx_hz * time)
    phi = speed = 0.0
    for each in push:
        speed += dt * (each - omega**2 * sine(phi))
        phi += dt * speed
    return math.hypot(phi, speed / omega)


def test_the_swing_by_design_is_that_of_the_driven_oscillator():
    found = numbers.expectation(load_specimen("jewel")[0])
    omega = 2 * math.pi * found.f_nat_hz
    drive = 0.014625 / 9.92429e-11 * 50e-6
    assert found.swing_rad_per_t * 50e-6 * 10 == pytest.approx(driven(drive, 10, found.f_nat_hz, omega), rel=0.02)


@pytest.mark.parametrize("beside", [0.85, 1.15])
def test_a_broad_burst_reaches_what_is_15_percent_beside_it(beside):
    omega = OMEGA * beside
    share = driven(100.0, 3, 213.0, omega) / driven(100.0, 3, 213.0 * beside, omega)
    assert numbers.effect_beside(3, 213.0, 213.0 * beside) == pytest.approx(share, abs=0.15)
    assert share > 0.5


def test_as_many_periods_as_still_push():
    measured = numbers.Measured(213.0, 0.1, 0.0, 0.1 / 490e-6, 1e-3)
    periods = numbers.most_periods(measured, 490e-6, 1.0, 1.0)
    drive = 0.1 * 2 * OMEGA * 213.0
    swings = [driven(drive, n, 213.0, OMEGA, math.sin) for n in (periods - 2, periods)]
    assert swings[1] > 1.05 * swings[0]
    shifted = numbers.mean_frequency_hz(213.0, 0.1 * periods)
    assert driven(drive, periods, shifted, OMEGA, math.sin) > swings[1]
    assert numbers.most_periods(measured, 490e-6, 490e-6 * 4, 1.0) == 4
    assert numbers.most_periods(measured, 490e-6, 1.0, 3.5 / 213.0) == 3


@pytest.mark.parametrize(("damping", "friction"), [(0.25, 0.0), (0.1, 1300.0), (0.0, 1300.0)])
def test_the_time_of_a_decay_is_the_inverse_of_what_remains(damping, friction):
    after_s = time_until(1.0, 0.3, damping, friction, OMEGA)
    assert remaining_amplitude(1.0, damping, friction, OMEGA, after_s) == pytest.approx(0.3)
    assert time_until(0.3, 1.0, damping, friction, OMEGA) == 0.0


def test_without_friction_it_takes_for_ever_and_the_window_stays_finite():
    measured = numbers.Measured(213.0, 0.0, 0.0, 100.0, 1e-3)
    assert measured.falls_in_s(1.0, 0.1) == math.inf
    assert numbers.listening_s(measured, 0.5, 0.05) == numbers.LONGEST_RX_S
    assert numbers.pause_s(measured, 0.5, 60.0) == numbers.LONGEST_WAIT_S - 60.0


def test_a_sequence_that_limits_have_decided_says_which():
    assert numbers.limits_reached(0.7, rx_s=2.4, pause_s=3.0, listened_s=2.4) == ()
    assert numbers.limits_reached(2.0, rx_s=None, pause_s=None, listened_s=60.0) == (
        "the swing is taken as 90 degrees, the largest that is expected",
    )
    slow = numbers.Measured(200.0, 1e-4, 0.0, 100.0, 1e-6)
    rx_s = numbers.listening_s(slow, 0.7, 0.05)
    pause_s = numbers.pause_s(slow, 0.7, rx_s)
    said = numbers.limits_reached(0.7, rx_s=rx_s, pause_s=pause_s, listened_s=rx_s)
    assert [text[:5] for text in said] == ["t_RX ", "the n"]
