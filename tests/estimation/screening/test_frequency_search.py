"""The frequency of a short stretch, and its medians."""

from __future__ import annotations

import numpy as np
import pytest

from platform_daemon.estimation.numerics.arrays import medians
from platform_daemon.estimation.screening.frequency_search import best_frequency

STEP_S = 2e-4


@pytest.mark.parametrize("frequency_hz", [190.0, 213.3, 229.9])
@pytest.mark.parametrize("second", [0.1, 3.0])
def test_the_search_finds_the_fundamental_though_its_second_harmonic_be_stronger(frequency_hz, second):
    turn = 2.0 * np.pi * frequency_hz * STEP_S * np.arange(240)
    data = np.stack([5.0 + np.cos(turn), second * np.sin(2.0 * turn + 0.4)])
    centre = 2.0 * np.pi * 210.0
    found = best_frequency(data, STEP_S, 0.88 * centre, 1.12 * centre, np.ones(2)) / (2.0 * np.pi)
    resolved_hz = 1.0 / (240 * STEP_S)
    assert found == pytest.approx(frequency_hz, abs=0.1 * resolved_hz)


@pytest.mark.parametrize("n", [1, 2, 7, 10])
def test_medians_are_those_of_numpy(n):
    values = np.random.default_rng(n).standard_normal((3, n))
    assert np.array_equal(medians(values), np.median(values, axis=1))
