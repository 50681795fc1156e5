"""A second process that compiles half of the kernels where none is compiled yet, into the cache that this one reads.

numba compiles under one lock, so that a second thread would only wait. A fit comes to the tables of half swings first
and to the sums over the samples last: the other process begins with the sums. What it has not finished in time is
compiled here, as if it did not exist.
"""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache

from .moments import tabulated
from .numerics.jit import is_cached
from .physics.trajectory import half_cycle_walk

_TABLES = ("build_table", "walk_swings")
_CHILD = "MMR_COMPILES_BESIDE"  # set in the other process, which starts none


@cache
def compile_beside() -> subprocess.Popen[bytes] | None:
    """Start the other process, once, if it can help; None if the kernels are in the cache, or there is one core."""
    alone = len(os.sched_getaffinity(0)) < 2 or not sys.executable
    if alone or _CHILD in os.environ or is_cached(tabulated.collect_swings):
        return None
    paths = os.pathsep.join(filter(None, sys.path))
    try:
        return subprocess.Popen(
            [sys.executable, "-c", f"from {__name__} import compile_sums; compile_sums()"],
            env={**os.environ, _CHILD: "1", "PYTHONPATH": paths},
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
    except OSError:
        return None


def compile_sums() -> None:
    """What the other process does: a fit whose tables are made by plain Python, so that only the rest is compiled."""
    from .compilation import made_up
    from .fit import fit_ring_down

    for name in _TABLES:
        setattr(half_cycle_walk, name, getattr(half_cycle_walk, name).py_func)
    record, noise = made_up()
    fit_ring_down(record, "thread", noise=noise)
