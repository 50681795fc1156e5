"""A shot on one grid of fewer samples: the swing as it was, and noise of a known level."""

import numpy as np
import pytest

from platform_daemon.diagnosis.shots.shot import SampleGrid, band_sd, even_grid
from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.record import RingDownRecord

RATE_HZ, SWING_HZ = 61035.15625, 215.0
FIRST, SAMPLES = 37, 60000


def record(row):
    return RingDownRecord(np.stack([row, -row, row]), RATE_HZ, "dmdt", valid_from=FIRST)


@pytest.mark.parametrize("harmonic", [0.02, 1.0, 2.0, 6.4])
def test_a_harmonic_is_what_it_was_at_the_instants(harmonic):
    wave = np.cos(2.0 * np.pi * harmonic * SWING_HZ * np.arange(SAMPLES) / RATE_HZ + 0.3)
    grid = even_grid(record(wave), SWING_HZ)
    there = np.arange(grid.first, grid.last) * grid.factor
    assert grid.factor > 5
    assert there[0] - FIRST < 2e-3 * RATE_HZ
    assert SAMPLES - there[-1] < 2e-3 * RATE_HZ
    np.testing.assert_allclose(grid.of(record(wave).samples)[1], -wave[there], atol=1e-6)


def test_noise_has_the_density_and_the_squares_that_are_stated():
    noise = np.random.default_rng(2).normal(0.0, 0.3, (40, SAMPLES))
    grid = even_grid(record(noise[0]), SWING_HZ)
    left = grid.of(noise)
    model = NoiseModel.white(np.array([0.3, 0.6, 0.3]), RATE_HZ)
    sd = band_sd(model, SWING_HZ, RATE_HZ) / np.sqrt(grid.factor)
    assert sd[1] == pytest.approx(2.0 * sd[0])
    assert np.mean((left / sd[0]) ** 2) == pytest.approx(grid.dof / grid.count, rel=0.01)
    wave = np.cos(2.0 * np.pi * 2.0 * SWING_HZ * np.arange(grid.count) * grid.factor / RATE_HZ)
    assert np.std(left @ wave) == pytest.approx(sd[0] * np.linalg.norm(wave), rel=0.35)  # of 40 rows


def test_a_slow_record_keeps_every_sample():
    slow = RingDownRecord(np.zeros((3, 900)), 20.0 * SWING_HZ, "dmdt", valid_from=5)
    assert even_grid(slow, SWING_HZ) == SampleGrid.every_sample(slow)
    assert even_grid(slow, SWING_HZ).of(slow.samples).shape == (3, 895)


def test_a_record_as_short_as_the_filter_keeps_every_sample():
    short = RingDownRecord(np.zeros((3, 400)), RATE_HZ, "dmdt", valid_from=5)
    assert even_grid(short, SWING_HZ) == SampleGrid.every_sample(short)
