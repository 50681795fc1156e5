"""The line that rings in a shot: its frequency, its size, and silence, mains and lines elsewhere."""

import numpy as np
import pytest

from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.features.procedures.ringing import line_in

RATE_HZ = 20e3


def record(frequency_hz: float, amplitude: float, decay_per_s: float = 1.0, seed: int = 1) -> RingDownRecord:
    """A decaying line in the first of three channels, in white noise of sd 1 and 3."""
    time = np.arange(int(1.0 * RATE_HZ)) / RATE_HZ
    noise = np.random.default_rng(seed).normal(size=(3, time.size)) * np.array([[1.0], [1.0], [3.0]])
    noise[0] += amplitude * np.exp(-decay_per_s * time) * np.sin(2 * np.pi * frequency_hz * time)
    return RingDownRecord(noise, RATE_HZ, "dmdt")


@pytest.mark.parametrize("decay_per_s", [0.2, 8.0])
@pytest.mark.parametrize("frequency_hz", [187.0, 213.3, 263.0])
def test_a_line_below_the_noise_of_a_sample_is_found(frequency_hz, decay_per_s):
    found = line_in(record(frequency_hz, 0.7, decay_per_s), 225.0)
    assert found.frequency_hz == pytest.approx(frequency_hz, abs=1.0)


def test_its_size_is_told_against_the_noise_of_the_channel_where_it_is_strongest():
    assert line_in(record(213.3, 20.0), 213.0).snr == pytest.approx(20.0 * np.exp(-0.05), rel=0.05)


@pytest.mark.parametrize("seed", range(20))
def test_noise_does_not_ring(seed):
    assert line_in(record(213.0, 0.0, seed=seed), 213.0) is None


def test_mains_and_what_is_far_from_the_expected_frequency_do_not_ring():
    assert line_in(record(250.0, 2.0, 0.0), 240.0) is None
    assert line_in(record(330.0, 2.0), 230.0) is None
