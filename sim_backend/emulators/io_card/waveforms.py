"""Periodic waveforms as sums of sines, because the coils' currents are solved for sines in closed form."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

HARMONICS = 40
NEGLIGIBLE = 1e-6

Partials = tuple[tuple[int, float, float], ...]


@lru_cache
def partials(signal: str) -> Partials:
    """(harmonic, amplitude, phase rad) of a waveform of unit amplitude; sine phases."""
    if signal == "SINE":
        return ((1, 1.0, 0.0),)
    odd = range(1, 2 * HARMONICS, 2)
    if signal == "SQUARE":
        return tuple((n, 4 / (np.pi * n), 0.0) for n in odd)
    if signal == "TRIANGLE":
        return tuple((n, 8 / (np.pi * n) ** 2 * (-1) ** (n // 2), 0.0) for n in odd)
    return tuple((n, 2 / (np.pi * n) * (-1) ** (n + 1), 0.0) for n in range(1, HARMONICS + 1))


def table_partials(table: NDArray[np.float64]) -> Partials:
    """The strongest harmonics (n, amplitude, phase) of a table that is played round and round; n = 0 is its mean."""
    spectrum = 2 * np.fft.rfft(table) / table.size
    spectrum[0] /= 2
    strongest = np.argsort(-np.abs(spectrum))[:HARMONICS]
    return tuple(
        (int(n), float(abs(spectrum[n])), float(np.angle(spectrum[n]) + np.pi / 2))
        for n in sorted(strongest)
        if abs(spectrum[n]) > NEGLIGIBLE
    )
