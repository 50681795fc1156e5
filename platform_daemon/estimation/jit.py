"""Compilation of the numerical kernels: lazy, cached, released from the GIL.

numba's on-disk cache looks at the time stamp of the *one* file a function stands in. A torque term edited in its own
module would leave the kernel that inlines it stale. So every kernel here is stamped with a digest of all kernel
sources: change any of them, and all are compiled anew.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba

_ROOM = Path(__file__).parent


@cache
def _sources_digest() -> str:
    """Digest of all files with kernels, and of the tableau compiled into them, so that no kernel can be stale."""
    digest = hashlib.sha256()
    for path in sorted(_ROOM.rglob("*.py")):
        text = path.read_bytes()
        if b"kernel\ndef" in text or b"inlined\ndef" in text or path.name == "tableau.py":
            digest.update(path.name.encode() + text)
    return digest.hexdigest()


def kernel(function: Callable[..., Any]) -> Any:
    """Compile `function` at its first call (nogil, float64, cached on disk); importing a module compiles nothing."""
    dispatcher = numba.njit(nogil=True, cache=True, error_model="numpy", no_cfunc_wrapper=True)(function)
    _stamp(dispatcher)
    return dispatcher


def fast_kernel(function: Callable[..., Any]) -> Any:
    """Like `kernel`, for loops over numbers: sums may be reordered, and so run in parallel lanes. NaN stays NaN."""
    dispatcher = numba.njit(
        nogil=True, cache=True, error_model="numpy", no_cfunc_wrapper=True, fastmath={"reassoc", "contract"}
    )(function)
    _stamp(dispatcher)
    return dispatcher


def inlined(function: Callable[..., Any]) -> Any:
    """For a few lines that many kernels share: pasted into each caller, which compiles three times faster."""
    return numba.njit(nogil=True, error_model="numpy", inline="always")(function)


def _stamp(dispatcher: Any) -> None:
    """Make the cache of `dispatcher` depend on all kernel sources instead of on one file's time."""
    cache_file = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if cache_file is not None and hasattr(cache_file, "_source_stamp"):
        cache_file._source_stamp = _sources_digest()
