"""The noise of an angle, however long the record, however coarse and however dense its samples."""

import numpy as np
import pytest

from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.record import RingDownRecord


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
