"""Closed forms of the free orbit against Jacobi's elliptic functions."""

import math

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from platform_daemon.estimation.physics.orbit import (
    amplitude_from_second_harmonic,
    amplitude_from_third_harmonic,
    first_harmonic,
    frequency_ratio,
)


def orbit_harmonics(amplitude):
    """Frequency ratio and amplitudes of harmonics 1..3 of d(sin phi)/dt, d(cos phi)/dt, by Jacobi functions."""
    k = math.sin(amplitude / 2)
    period = 4 * ellipk(k * k)
    s = np.linspace(0, period, 4096, endpoint=False)
    sn, _, dn, _ = ellipj(s + period / 4, k * k)
    phi = 2 * np.arcsin(k * sn)
    v = np.gradient(phi, s, edge_order=2)
    del dn
    waves = [np.abs(np.fft.rfft(x)) * 2 / s.size for x in (v * np.cos(phi), -v * np.sin(phi))]
    return 2 * math.pi / period, waves[0][1], waves[1][2], waves[0][3]


@pytest.mark.parametrize("degrees", [5.0, 20.0, 53.0, 75.0])
def test_closed_form_harmonics_agree_with_the_jacobi_orbit(degrees):
    amplitude = math.radians(degrees)
    frequency, v1, u2, v3 = orbit_harmonics(amplitude)
    assert frequency_ratio(amplitude) == pytest.approx(frequency, rel=1e-10)
    assert first_harmonic(amplitude) == pytest.approx(v1, rel=1e-4)
    assert amplitude_from_second_harmonic(u2 / v1) == pytest.approx(amplitude, rel=1e-4)
    assert amplitude_from_third_harmonic(v3 / v1) == pytest.approx(amplitude, rel=1e-3)
