"""A free swing is never taken for a driven one."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import RefusedError
from platform_daemon.estimation.screening.screening import screen_free_swing


def read(angle, count, noise, seed):
    random = np.random.default_rng(seed)
    return count * np.round((angle + noise * count * random.standard_normal(angle.size)) / count)


def free(quality, periods, seed, f_hz=1.3, rate_hz=500.0, start=0.5):
    t = np.arange(int(periods / f_hz * rate_hz)) / rate_hz
    phase = np.random.default_rng(seed).uniform(0.0, 6.0)
    return t, start * np.exp(-math.pi * f_hz / quality * t) * np.cos(2.0 * math.pi * f_hz * t + phase)


def record(angle, rate_hz=500.0):
    return RingDownRecord(angle[None], rate_hz, "angle")


@pytest.mark.parametrize("quality", [30.0, 300.0, 3e3, 3e4])
@pytest.mark.parametrize("periods", [6, 25, 100])
@pytest.mark.parametrize(("count", "noise"), [(8e-4, 0.5), (8e-4, 0.02), (1e-2, 0.1)])
def test_a_free_swing_passes_however_little_it_loses(quality, periods, count, noise):
    for seed in range(4):
        screen_free_swing(record(read(free(quality, periods, seed)[1], count, noise, seed)))


def test_a_push_is_no_drive():
    t, angle = free(2e3, 60, 1)
    late = t - 20.0
    angle = angle + (late > 0.0) * 0.3 * np.sin(2.0 * math.pi * 1.3 * late) * np.exp(-2e-3 * late)
    screen_free_swing(record(read(angle, 8e-4, 0.5, 1)))


@pytest.mark.parametrize("gain_per_s", [0.0, 1e-3, 0.02])
def test_a_swing_that_loses_nothing_or_gains_is_refused(gain_per_s):
    t, _ = free(1e9, 60, 1)
    angle = 0.4 * np.exp(gain_per_s * t) * np.sin(2.0 * math.pi * 1.3 * t)
    with pytest.raises(RefusedError, match=r"no_decay: .*is it driven"):
        screen_free_swing(record(read(angle, 8e-4, 0.5, 1)))


def test_a_beat_is_refused_with_its_place():
    t, _ = free(1e9, 60, 1)
    angle = 0.3 * np.sin(2.0 * math.pi * 1.3 * t) - 0.25 * np.sin(2.0 * math.pi * 1.4 * t)
    with pytest.raises(RefusedError, match=r"no_decay: the swing grows from .* s: is it driven, or does a second"):
        screen_free_swing(record(read(angle, 8e-4, 0.5, 1)))
