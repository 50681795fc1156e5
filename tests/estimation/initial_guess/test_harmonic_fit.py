"""A fit of harmonics to a short part of a record."""

import math

import numpy as np
import pytest

from platform_daemon.estimation.initial_guess.harmonic_fit import fit_harmonics


@pytest.mark.parametrize("true_hz", [196.0, 209.0, 210.0, 211.5, 228.0])
def test_a_harmonic_fit_finds_a_frequency_near_and_far(true_hz):
    dt_s, n = 1.6e-5, 2980
    phase = 2.0 * math.pi * true_hz * dt_s * np.arange(n)
    y = np.stack([2.0 * np.cos(phase), 0.3 * np.sin(2.0 * phase)])
    seen = fit_harmonics(y, first=0, last=n, dt_s=dt_s, frequency_hz=210.0, noise_sd=np.full(2, 1e-3))
    assert seen.omega / (2.0 * math.pi) == pytest.approx(true_hz, rel=1e-4)
    assert np.abs(seen.z[0]) == pytest.approx([2.0, 0.0], abs=2e-3)
    assert np.abs(seen.z[1]) == pytest.approx([0.0, 0.3], abs=2e-3)
