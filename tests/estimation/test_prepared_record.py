"""Periods of a record too short for a spectrum."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.prepared_record import counted_periods
from tests.kit.ring_down_generator import RATE_HZ, dmdt, random_truth, with_noise


@pytest.mark.parametrize("periods", [2.3, 4.0, 6.5, 12.0])
@pytest.mark.parametrize("seed", range(4))
def test_periods_are_counted_whatever_the_upper_estimate_of_the_frequency(periods, seed):
    rng = np.random.default_rng(seed)
    truth = random_truth(rng, "thread", deg_range=(8.0, 60.0))
    slower = 1.0 - (truth.phi_max_rad**2) / 16.0
    seconds = periods / (truth.f_nat_hz * slower)
    y = with_noise(dmdt(truth, seconds), rng)
    for factor in (1.0, 2.0, 4.0):
        assert counted_periods(y, dt_s=1.0 / RATE_HZ, frequency_hz=factor * truth.f_nat_hz) == pytest.approx(
            periods, abs=0.3
        )


def test_a_record_without_swings_has_no_periods():
    assert counted_periods(np.ones((3, 500)), dt_s=1.0 / RATE_HZ, frequency_hz=200.0) == 0.0
    assert math.isfinite(counted_periods(np.zeros((1, 500)), dt_s=1.0 / RATE_HZ, frequency_hz=200.0))


def test_a_window_of_less_than_one_point_holds_the_periods_of_the_estimate():
    assert counted_periods(np.ones((3, 2)), dt_s=0.1, frequency_hz=0.2) == pytest.approx(0.04)
