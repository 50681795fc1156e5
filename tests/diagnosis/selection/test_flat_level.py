"""The level of what a fit leaves of an angle: of white noise its own, of a coarse encoder that near the swing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from platform_daemon.diagnosis.selection.select_effects import flat_level
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.record import RingDownRecord

RATE, SWING_HZ = 5000.0, 1.4
TIME = np.arange(int(20.0 * RATE)) / RATE
WHITE = np.random.default_rng(1).standard_normal(TIME.size)


@pytest.mark.parametrize("sweep", [0.0, 0.1])
def test_slow_quantisation_is_no_quieter_than_it_is_near_the_swing(sweep):
    """Record 72 of the angle study: at a third of the power near the swing, no fit left noise any more.

    Swept harmonics fill the band; of a steady swing they are lines, which a median does not see.
    """
    turns = SWING_HZ * TIME * (1.0 - sweep * (1.0 - TIME / TIME[-1]))
    swing = 1.4 * np.exp(-0.008 * TIME) * np.cos(2.0 * math.pi * turns)
    step = 2.4 * 1.4 / 2**8
    read = step * np.round(swing / step + 0.1 * WHITE)
    taken = float(estimate_noise(RingDownRecord(read[None], RATE, "angle")).sd[0])
    level = flat_level((read - swing)[None], SWING_HZ / RATE)
    assert level == pytest.approx(taken, rel=1.0 - THRESHOLDS.selection.quieter_share)


@pytest.mark.parametrize("rate_hz", [RATE, 40.0 * SWING_HZ, 20.0 * SWING_HZ])
def test_white_noise_has_its_own_level(rate_hz):
    line = 3.0 * np.cos(2.0 * math.pi * 9.2 * SWING_HZ * TIME)
    assert flat_level((WHITE + line)[None], SWING_HZ / rate_hz) == pytest.approx(1.0, rel=0.1)


def test_a_filtered_angle_has_none():
    filtered = sosfiltfilt(butter(4, 0.4, output="sos"), WHITE)
    assert flat_level(filtered[None], SWING_HZ / RATE) is None
