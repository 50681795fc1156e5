"""Compiling everything that a fit needs, before the first shot does."""

from __future__ import annotations

import time

import numpy as np

from .fit import fit_ring_down
from .models import THREAD
from .noise import NoiseModel
from .record import RingDownRecord
from .sampling import DIPOLE
from .trajectory import Dynamics, Trajectory

_RATE_HZ = 8000.0
_SAMPLES = 1200


def warm_up() -> float:
    """Compile all kernels (or load them from numba's cache); returns the seconds it took. Safe in any thread.

    It fits a made-up ring-down, so that nothing is left to compile for a real one.
    """
    began = time.perf_counter()
    dynamics = Dynamics(2.0 * np.pi * 200.0, 2.0, 0.6, (0.5,))
    basis = Trajectory(THREAD, dynamics, _SAMPLES / _RATE_HZ).basis(0, _SAMPLES, 1.0 / _RATE_HZ, DIPOLE)
    signal = np.array([[1.0, 0.0], [0.0, 1.0], [0.3, 0.2]]) @ basis[:2]
    # Not at random, but white enough for a start value.
    signal += 1e-3 * np.sin(1e4 * np.arange(signal.size, dtype=np.float64) ** 2).reshape(signal.shape)
    noise = NoiseModel.white(np.full(3, 1e-3), _RATE_HZ)
    fit_ring_down(RingDownRecord(signal, _RATE_HZ, "dmdt"), "thread", noise=noise)
    return time.perf_counter() - began
