"""The noise of an angle that was filtered or integrated is what its swing leaves, not the digits of its numbers."""

import numpy as np
import pytest

from platform_daemon.diagnosis.shots.initial_fits import initial_fits
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.diagnosis.shots.thread_pool import InlineExecutor
from platform_daemon.estimation.noise.angle import angle_sd_beside_waves
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.physics.models import THREAD
from platform_daemon.estimation.record import RingDownRecord
from tests.kit.pendulum import NATURAL_HZ, RATE, swing


def noise_after(read):
    """(standard deviation that differences show, the one of the prepared shot), rad."""
    record = RingDownRecord(read[None], RATE, "angle")
    shot = DiagnosisShot("swing", record, estimate_noise(record))
    (prepared,), _ = initial_fits([shot], THREAD, InlineExecutor())
    return float(shot.noise.sd[0]), float(prepared.shot.noise.sd[0])


def test_a_filtered_angle_has_the_noise_of_its_slow_errors():
    angle = swing(0.4, 20)
    time = np.arange(angle.size) / RATE
    slow = np.sum([3e-4 * np.sin(2.0 * np.pi * f * time + f) for f in (0.43, 1.31, 2.9, 5.3)], axis=0)
    differences, sd = noise_after(angle + slow)
    assert differences < 1e-5
    assert 3e-5 < sd < 6e-4


@pytest.mark.parametrize("dry", [0.0, 0.006])
def test_white_noise_stays_that_of_the_differences_whatever_the_friction(dry):
    read = swing(0.8, 12, dry=dry) + np.random.default_rng(1).normal(0.0, 3e-4, int(12 * RATE / NATURAL_HZ))
    differences, sd = noise_after(read)
    assert sd == differences == pytest.approx(3e-4, rel=0.1)


def test_samples_that_are_multiples_of_a_step_were_not_filtered():
    counted = np.round(swing(0.4, 10) / 1e-3) * 1e-3
    assert angle_sd_beside_waves(RingDownRecord(counted[None], RATE, "angle"), NATURAL_HZ) is None
