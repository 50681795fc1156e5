"""How many periods a short record holds: a spectrum of so few has no lines."""

from __future__ import annotations

import numpy as np

from ..numerics.arrays import Array

FEW_PERIODS = 14.0  # below, a spectrum's line may be a side lobe or a harmonic
_PER_PERIOD = 16.0
_LEVEL = 0.5  # of the largest deflection, which noise does not reach from the other side


def counted_periods(y: Array, dt_s: float, frequency_hz: float) -> float:
    """Periods in samples (channels, n), from the swings of their strongest combination.

    frequency_hz: an upper estimate; sets over how many samples noise is averaged.
    """
    block = max(1, int(1.0 / (_PER_PERIOD * frequency_hz * dt_s)))
    n = y.shape[1] // block
    means = y[:, : n * block].reshape(y.shape[0], n, block).mean(axis=2)
    means -= means.mean(axis=1, keepdims=True)
    strongest = np.linalg.eigh(means @ means.T)[1][:, -1]
    turns = _turns(strongest @ means)
    if turns.size < 3:
        return 0.5 * turns.size
    return float(n * (turns.size - 1) / (2.0 * (turns[-1] - turns[0])))


def _turns(s: Array) -> Array:
    """Where s (n,) passes from one side to the other, fractional samples: between half its height there and back."""
    sides = np.where(np.abs(s) > _LEVEL * np.abs(s).max(), np.sign(s), 0.0)
    places = np.flatnonzero(sides)
    changes = np.flatnonzero(np.diff(sides[places]))
    return np.asarray(0.5 * (places[changes] + places[changes + 1]))
