"""What is taken from the samples, in one pass, is what plain interpolation by numpy makes of the harmonics."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, interp1d

from platform_daemon.estimation.rotor_correction.motion import BETWEEN, HARMONICS, THIN, less_harmonics


def slow(samples, seed=3):
    rng, thin = np.random.default_rng(seed), -(-samples // THIN) + 1
    phase = np.cos(np.outer(np.arange(HARMONICS), 0.02 * np.arange(thin)) + 0.3)
    nodes = -(-thin // BETWEEN) + 1
    return rng.standard_normal((nodes, 3, HARMONICS)), phase


@pytest.mark.parametrize("samples", [1, 7, 8, 9, BETWEEN * THIN - 1, BETWEEN * THIN, 5 * BETWEEN * THIN + 3])
def test_harmonics_between_the_nodes_are_taken_away(samples):
    harmonics, phase = slow(samples)
    thin = np.arange(phase.shape[1])
    between = interp1d(np.arange(len(harmonics)) * BETWEEN, harmonics, axis=0)(thin)
    expected = np.einsum("nch,hn->cn", between, phase)
    given = np.random.default_rng(4).standard_normal((3, samples + 5))[:, :samples]
    left = given - less_harmonics(given, harmonics, phase)
    assert np.allclose(left[:, ::THIN], expected[:, : -(-samples // THIN)], rtol=0, atol=1e-12)
    if samples > BETWEEN * THIN:  # inside, a spline of the same places; it is rounder where the drift bends
        smooth = CubicSpline(THIN * thin[: BETWEEN - 2], expected[:, : BETWEEN - 2], axis=1)
        inside = np.arange(THIN, (BETWEEN - 4) * THIN)
        assert np.abs(left[:, inside] - smooth(inside)).max() < 1e-3 * np.abs(expected).max()


def test_too_few_nodes_or_places_are_no_garbage_but_an_error():
    harmonics, phase = slow(5000)
    given = np.zeros((3, 5000))
    for fewer in ((harmonics[:-1], phase), (harmonics, phase[:, :-1])):
        with pytest.raises(ValueError, match="do not reach"):
            less_harmonics(given, *fewer)
