"""The parts of every search for lines: level, place between bins, and whose a line may be."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.physics.orbit import frequency_ratio
from platform_daemon.estimation.screening.spectral_lines import Zones, is_mains, median_level, peak_shift, periodogram


@pytest.mark.parametrize("window", [np.ones(4096), np.kaiser(4096, 8.0), np.blackman(4096)])
def test_white_noise_has_its_variance_in_every_bin_of_any_window(window):
    noise = np.random.default_rng(0).standard_normal((8, 4096)) * np.arange(1, 9)[:, None]
    power = periodogram(noise, window)[:, 8:-8]
    assert power.mean(axis=1) == pytest.approx(np.arange(1, 9) ** 2, rel=0.1)
    assert np.mean(power > 3.0 * np.arange(1, 9)[:, None] ** 2) == pytest.approx(math.exp(-3.0), rel=0.15)


def test_a_level_of_medians_follows_the_colour_and_not_a_line():
    noise = np.random.default_rng(1).standard_normal((1, 20000))
    power = periodogram(noise, np.ones(20000)) * np.linspace(1.0, 3.0, 10001)
    strong = power.copy()
    strong[0, 4000] = 1e6
    edges = 200 * np.arange(51)
    level = median_level(strong, edges)
    assert level / math.log(2.0) == pytest.approx(np.linspace(1.0, 3.0, 10001)[None], rel=0.35)
    assert level == pytest.approx(median_level(power, edges), rel=0.02)


@pytest.mark.parametrize("between", [-0.4, -0.1, 0.0, 0.25, 0.5])
def test_a_line_is_placed_between_the_bins(between):
    n = 1024
    power = periodogram(np.cos(2 * np.pi * (100 + between) / n * np.arange(n))[None], np.kaiser(n, 8.0), 2 * n)[0]
    peak = int(np.argmax(power))
    assert (peak + peak_shift(power, peak)) / 2 == pytest.approx(100 + between, abs=0.01)
    assert peak_shift(power, 0) == peak_shift(power, n) == 0.0


def test_mains_is_a_multiple_of_50_or_60_hz_as_near_as_mains_wanders():
    found = [f for f in (10.0, 49.9, 55.0, 59.9, 149.5, 215.0, 300.4) if is_mains(f, relative=0.004)]
    assert found == [49.9, 59.9, 149.5, 300.4]
    assert is_mains(49.5, relative=0.004, missed_hz=0.4)
    assert not is_mains(60.0, relative=0.004, mains_hz=(50.0,))


def test_a_swing_sweeps_its_harmonics_from_the_frequency_of_its_first_amplitude_to_the_natural_one():
    zones = Zones.of_sweep(2 * np.pi * 200.0, 1.5, relative=0.0, margin_hz=1.0)
    slowest = 200.0 * frequency_ratio(1.5)
    inside = np.concatenate([np.linspace(k * slowest, k * 200.0, 9) for k in range(1, 7)])
    assert zones.holds(inside).all()
    outside = [0.0, slowest - 1.5, 201.5, 2 * slowest - 1.5, 401.5]
    assert not zones.holds(np.array(outside)).any()
