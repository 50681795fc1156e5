"""Noise of known colour: every function gives (n,) samples; `density` functions give its power over that of white."""

import math

import numpy as np
from scipy.signal import butter, freqz, lfilter

from tests.kit.ring_down_generator import RATE_HZ

SETTLE = 20_000


def white(rng, n):
    return rng.standard_normal(n)


def pink(corner_hz, exponent=1.0):
    """White noise plus flicker noise that overtakes it below the corner."""

    def density(f):
        return 1.0 + (corner_hz / np.asarray(f)) ** exponent

    def make(rng, n):
        f = np.fft.rfftfreq(n, 1 / RATE_HZ)
        f[0] = f[1]
        return np.fft.irfft(np.sqrt(density(f)) * np.fft.rfft(rng.standard_normal(n)), n)

    return make, density


def one_pole(corner_hz):
    """White noise behind a low-pass."""
    a = math.exp(-2 * math.pi * corner_hz / RATE_HZ)
    return _filtered([1 - a], [1, -a], 0.0)


def band(low_hz, high_hz, height=16.0):
    """White noise with a band that stands out by so much."""
    b, a = butter(2, [low_hz, high_hz], "bandpass", fs=RATE_HZ)
    return _filtered(math.sqrt(height) * b, a, 1.0)


def _filtered(b, a, floor):
    def density(f):
        return floor + np.abs(freqz(b, a, np.asarray(f), fs=RATE_HZ)[1]) ** 2

    def make(rng, n):
        coloured = lfilter(b, a, rng.standard_normal(n + SETTLE))[SETTLE:]
        return coloured + math.sqrt(floor) * rng.standard_normal(n)

    return make, density


def three(make, sd, rng, n):
    """(3, n) independent channels."""
    return np.stack([s * make(rng, n) for s in sd])
