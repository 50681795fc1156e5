"""Compiles the numba kernels before the first shot."""

from __future__ import annotations

import time

import numpy as np

from sim_backend.options import ChainOptions
from sim_backend.receive.chain import receive_v
from sim_backend.rotor.motion import move
from sim_backend.rotor.torque import HERTZ, SLOTS, STIFFNESS
from sim_backend.rotor.trajectory import states

from . import shot  # noqa: F401 with all that it imports, so that the first shot imports nothing


def warm_up() -> float:
    """Run every kernel once on a millisecond of motion; return the elapsed time, s."""
    begin_s = time.perf_counter()
    q = np.zeros(SLOTS)
    q[STIFFNESS], q[HERTZ] = 1e6, 1e3
    motion = move(0.0, 1e-3, 0.1, 0.0, q)
    times = np.array([1e-4, 5e-4])
    states(motion.pieces, times)
    chain = ChainOptions(poles_hz=((2e4,), (), ()), residual_delay_s=(0.0, 0.0, 0.0))
    receive_v(motion.pieces, np.ones(len(motion.pieces), dtype=np.bool_), times, np.ones((3, 2)), chain)
    return time.perf_counter() - begin_s
