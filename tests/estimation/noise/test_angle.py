"""The noise of an angle, however long the record, however coarse and however dense its samples."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from platform_daemon.estimation.noise.angle import quietest_sd
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import NATURAL_HZ, RATE, swing


def swinging(seconds, rate, *, counts, noise, f_hz=1.3, loss=0.02, seed=0):
    """(angle (n,), standard deviation of its noise) of a swing of 1 rad, read in steps of 1/counts rad."""
    time, step = np.arange(int(seconds * rate)) / rate, 1.0 / counts
    angle = np.exp(-loss * time) * np.sin(2 * np.pi * f_hz * time * (1.0 + 0.002 * np.exp(-loss * time)))
    read = np.round((angle + np.random.default_rng(seed).normal(0, noise * step, time.size)) / step) * step
    return read, step * np.sqrt(noise**2 + 1.0 / 12.0)


@pytest.mark.parametrize("noise", [0.3, 1.0, 2.0])
@pytest.mark.parametrize(("seconds", "rate"), [(118.0, 1000.0), (100.0, 10_000.0), (60.0, 100.0), (8.0, 60.0)])
def test_white_noise_and_the_steps_of_an_encoder_are_measured_to_a_tenth(seconds, rate, noise):
    read, sd = swinging(seconds, rate, counts=800, noise=noise)
    assert estimate_noise(RingDownRecord(read[None], rate, "angle")).sd[0] == pytest.approx(sd, rel=0.12)


def test_an_encoder_that_is_read_more_often_than_it_counts_has_at_least_the_noise_of_its_steps():
    read, _ = swinging(10.0, 10_000.0, counts=100, noise=0.01)
    sd = float(estimate_noise(RingDownRecord(read[None], 10_000.0, "angle")).sd[0])
    rounding = 1.0 + 1e-9  # the angles were divided by a scale and multiplied again
    assert 0.01 / np.sqrt(12.0) <= sd * rounding < 4.0 * 0.01


def test_a_jump_and_a_kink_are_no_noise():
    read, sd = swinging(60.0, 1000.0, counts=800, noise=0.5)
    read[20_000:] += 0.3
    assert estimate_noise(RingDownRecord(read[None], 1000.0, "angle")).sd[0] == pytest.approx(sd, rel=0.15)


@pytest.mark.parametrize(("seconds", "rate"), [(5.0, 20.0), (5.0, 26.0), (30.0, 18.0)])
def test_few_samples_per_period_tell_the_noise_to_a_third(seconds, rate):
    read, sd = swinging(seconds, rate, counts=2000, noise=0.5)
    assert estimate_noise(RingDownRecord(read[None], rate, "angle")).sd[0] == pytest.approx(sd, rel=0.33)


def smoothed(rate, *, highest_hz, noise, decimals=None, line=0.0):
    """An angle of 1 rad with white noise, without what is above a frequency; rounded; beside a line."""
    read, _ = swinging(24.0, rate, counts=1e9, noise=0.0)
    time = np.arange(read.size) / rate
    read = read + line * np.cos(2 * np.pi * 2.1 * time) + np.random.default_rng(3).normal(0, noise, read.size)
    read = sosfiltfilt(butter(4, highest_hz, fs=rate, output="sos"), read)[int(2 * rate) : -int(2 * rate)]
    return read if decimals is None else np.round(read, decimals)


@pytest.mark.parametrize(
    ("highest_hz", "more"), [(16.0, {}), (24.0, {}), (16.0, {"decimals": 6}), (16.0, {"line": 0.01})]
)
def test_a_filtered_angle_has_at_least_the_noise_that_is_left_near_the_swing(highest_hz, more):
    read = smoothed(400.0, highest_hz=highest_hz, noise=3e-4, **more)
    sd = float(estimate_noise(RingDownRecord(read[None], 400.0, "angle")).sd[0])
    assert 1.2e-4 < sd < 4e-4


def test_no_measured_angle_is_quieter_than_a_converter():
    read = smoothed(400.0, highest_hz=6.0, noise=3e-4)
    record = RingDownRecord(read[None], 400.0, "angle")
    before = float(estimate_noise(record).sd[0])
    assert before < 1e-9
    assert 5e-5 < quietest_sd(record, before, 1.3) < 4e-4
    assert quietest_sd(record, 1e-4, 1.3) == 1e-4


def test_an_interpolated_angle_has_the_noise_of_what_was_read():
    slow = np.arange(24 * 30) / 30.0
    read, sd = swinging(24.0, 30.0, counts=2000, noise=0.5)
    dense = CubicSpline(slow, read)(np.arange(23 * 1000) / 1000.0)
    found = float(estimate_noise(RingDownRecord(dense[None], 1000.0, "angle")).sd[0])
    assert found == pytest.approx(sd * np.sqrt(1000.0 / 30.0), rel=0.35)


def test_a_quiet_angle_with_kinks_of_dry_friction_was_not_smoothed():
    read = swing(0.8, 20.0, dry=0.003) + np.random.default_rng(4).normal(0, 1e-6, int(20.0 * RATE / NATURAL_HZ))
    assert estimate_noise(RingDownRecord(read[None], RATE, "angle")).sd[0] == pytest.approx(1e-6, rel=0.15)
