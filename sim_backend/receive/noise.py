"""Noise of the receive side: white or coloured noise, and mains hum."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from sim_backend.options import ColourOptions, HumOptions


def noise_v(
    rng: np.random.Generator, sd_v: NDArray[np.float64], samples: int, rate_hz: float, colour: ColourOptions
) -> NDArray[np.float64]:
    """Noise of every channel: (channel, samples) float64, V, with rms sd_v (channel,) over the full band."""
    out = np.empty((sd_v.size, samples))
    for row, sd, corner_hz in zip(out, sd_v, colour.corner_hz, strict=True):
        if colour.enabled and corner_hz > 0:
            row[:] = sd * _coloured(rng, samples, rate_hz, corner_hz, colour.exponent)
        else:
            row[:] = sd * rng.standard_normal(samples)
    return out


def _coloured(
    rng: np.random.Generator, samples: int, rate_hz: float, corner_hz: float, exponent: float
) -> NDArray[np.float64]:
    """Unit-variance noise with power density 1 + (corner/f)^exponent, flat below the record's lowest frequency."""
    n = next_fast_len(samples, real=True)
    f = rfftfreq(n, 1 / rate_hz)
    f[0] = f[1] if f.size > 1 else rate_hz
    gain = np.sqrt(1 + (corner_hz / f) ** exponent)
    gain /= np.sqrt(np.mean(gain**2))
    return np.asarray(irfft(gain * rfft(rng.standard_normal(n)), n)[:samples])


def hum_v(
    hum: HumOptions, phases_rad: NDArray[np.float64], world_s: NDArray[np.float64], per_am2: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Mains hum of every channel at world times (n,): (channel, n) float64, V.

    phases_rad: (harmonic, channel); per_am2: (channel,) V per A m^2/s.
    """
    out = np.zeros((per_am2.size, world_s.size))
    for k, (levels, phases) in enumerate(zip(hum.amplitude_am2_per_s, phases_rad, strict=True)):
        angle = 2 * np.pi * hum.frequency_hz * (k + 1) * world_s
        for row, level, phase, scale in zip(out, levels, phases, per_am2, strict=True):
            row += level * scale * np.sin(angle + phase)
    return out
