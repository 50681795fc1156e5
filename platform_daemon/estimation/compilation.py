"""Compiling everything that a fit needs, before the first shot does."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numba.core import config

from .fit import fit_ring_down
from .moments.tabulated import collect_half_cycles
from .noise.model import NoiseModel
from .physics.trajectory.basis_functions import fill_basis
from .physics.trajectory.direct_chain import trace_half_cycles
from .physics.trajectory.half_cycle_chain import walk_half_cycles
from .physics.trajectory.half_cycle_table import build_table
from .record import RingDownRecord

_RATE_HZ = 8000.0
_SAMPLES = 1200
_KERNELS = (build_table, walk_half_cycles, collect_half_cycles, trace_half_cycles, fill_basis)
COMPILING = "compiling the fit, once for each installation: about half a minute on an idle computer"


def is_compiled() -> bool:
    """Whether the kernels that take longest to compile are loaded or in numba's cache."""
    return config.DISABLE_JIT or all(kernel.signatures or _is_cached(kernel) for kernel in _KERNELS)


def _is_cached(kernel: Any) -> bool:
    # numba has no public way to look into its cache; its index is empty where any source of the kernels has changed.
    cache_file = getattr(kernel._cache, "_cache_file", None)  # noqa: SLF001
    return cache_file is not None and bool(cache_file._load_index())  # noqa: SLF001


def warm_up() -> float:
    """Compile all kernels (or load them from numba's cache); returns the seconds it took. Safe in any thread.

    It fits a made-up ring-down, so that nothing is left to compile for a real one.
    """
    began = time.perf_counter()
    record, noise = synthetic_record()
    result = fit_ring_down(record, "thread", noise=noise)
    if result.verdict == "good":
        result.model_signal(4, _RATE_HZ)
    return time.perf_counter() - began


def synthetic_record() -> tuple[RingDownRecord, NoiseModel]:
    """A short record that can be fitted, and its noise."""
    time_s = np.arange(_SAMPLES) / _RATE_HZ
    # Not a ring-down, but in its noise near enough to one for a fit to pass as clean; nor is the noise at random.
    sway = np.exp(-0.5 * time_s) * np.array(
        [np.cos(2.0 * np.pi * 200.0 * time_s), np.sin(4.0 * np.pi * 200.0 * time_s)]
    )
    signal = np.array([[1.0, 0.0], [0.0, 0.2], [0.3, 0.05]]) @ sway
    signal += 0.1 * np.sin(1e4 * np.arange(signal.size, dtype=np.float64) ** 2).reshape(signal.shape)
    record = RingDownRecord(signal, _RATE_HZ, "dmdt")
    return record, NoiseModel.white(np.full(3, 0.1), _RATE_HZ)
