"""The frequency of a short stretch, and its means block by block."""

from __future__ import annotations

import numpy as np
import pytest

from platform_daemon.estimation.screening.frequency_search import best_frequency, block_means

STEP_S = 2e-4


@pytest.mark.parametrize("frequency_hz", [190.0, 213.3, 229.9])
@pytest.mark.parametrize("second", [0.1, 3.0])
def test_the_search_finds_the_fundamental_though_its_second_harmonic_be_stronger(frequency_hz, second):
    turn = 2.0 * np.pi * frequency_hz * STEP_S * np.arange(240)
    data = np.stack([5.0 + np.cos(turn), second * np.sin(2.0 * turn + 0.4)])
    centre = 2.0 * np.pi * 210.0
    found = best_frequency(data, step_s=STEP_S, lowest=0.88 * centre, highest=1.12 * centre, weights=np.ones(2)) / (
        2.0 * np.pi
    )
    resolved_hz = 1.0 / (240 * STEP_S)
    assert found == pytest.approx(frequency_hz, abs=0.1 * resolved_hz)


@pytest.mark.parametrize(("first", "block", "blocks"), [(0, 1, 50), (7, 8, 100), (3, 23, 40)])
def test_block_means_are_those_of_numpy(first, block, blocks):
    y = np.random.default_rng(1).standard_normal((2, 1000))
    expected = y[:, first : first + block * blocks].reshape(2, blocks, block).mean(axis=2)
    assert np.allclose(block_means(y, first, block, blocks), expected, rtol=1e-13, atol=1e-15)
