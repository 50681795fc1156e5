"""Compilation of the numerical kernels: lazy, cached, released from the GIL.

numba's on-disk cache looks at the time stamp of the *one* file that defines a function. A torque term edited in its own
module would leave the kernel that inlines it stale. So every kernel here is stamped with a digest of all kernel
sources: change any of them, and all are compiled again.

With NUMBA_DISABLE_JIT=1, for debuggers and coverage, everything here is plain Python, some hundred times slower.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core import config
from numba.core.compiler_lock import global_compiler_lock

_ROOM = Path(__file__).parents[1]
_OTHER_SOURCES = ("jit.py", "separate_functions.py", "dormand_prince.py")
_MARK = re.compile(rb"^@((fast_)?(kernel|part)|lane_part|inlined)$", re.MULTILINE)


def has_kernels(source: bytes) -> bool:
    """Whether a file of this text holds compiled functions."""
    return _MARK.search(source) is not None


@cache
def sources_digest() -> str:
    """Digest of all that compiled code depends on: files with kernels, their options, the tableau, the thresholds."""
    digest = hashlib.sha256()
    for path in sorted(_ROOM.rglob("*.py")):
        text = path.read_bytes()
        if has_kernels(text) or path.name in _OTHER_SOURCES or path.parent.name == "thresholds":
            digest.update(str(path.relative_to(_ROOM)).encode() + text)
    return digest.hexdigest()


def separate_digest(function: Callable[..., Any]) -> str:
    """Digest of all that a separately compiled function depends on: sources of kernels and the files of its folder."""
    digest = hashlib.sha256(sources_digest().encode())
    for path in sorted(Path(function.__code__.co_filename).parent.glob("*.py")):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
_FAST: dict[str, Any] = {"fastmath": {"reassoc", "contract"}}


def kernel(function: Callable[..., Any]) -> Any:
    """Compile `function` at its first call (nogil, float64, cached on disk); importing a module compiles nothing.

    Its loops do not run in parallel lanes: most are short, and laying them out so takes half of the compilation.
    """
    dispatcher = _entry(function, _OPTIONS)
    if config.DISABLE_JIT:
        return dispatcher
    dispatcher.compile = _without_lanes(dispatcher.compile)
    return dispatcher


def _without_lanes(compilation: Callable[..., Any]) -> Callable[..., Any]:
    """A compilation with numba's switch for lanes off; others wait for the same lock."""

    def compile_plainly(signature: Any) -> Any:
        with global_compiler_lock:
            before, config.LOOP_VECTORIZE = config.LOOP_VECTORIZE, 0
            try:
                return compilation(signature)
            finally:
                config.LOOP_VECTORIZE = before

    return compile_plainly


def fast_kernel(function: Callable[..., Any]) -> Any:
    """Like `kernel`, for loops over numbers: sums may be reordered, and so run in parallel lanes. NaN stays NaN."""
    return _entry(function, _OPTIONS | _FAST)


def part(function: Callable[..., Any]) -> Any:
    """A piece of kernels: compiled once, for all that call it; plain Python elsewhere."""
    return _inside(function, _OPTIONS)


def fast_part(function: Callable[..., Any]) -> Any:
    """A piece of kernels whose sums may be reordered."""
    return _inside(function, _OPTIONS | _FAST)


def lane_part(function: Callable[..., Any]) -> Any:
    """A `fast_part` that stands within a loop of its callers: a call would keep that loop from running in lanes."""
    return _inside(function, _OPTIONS | _FAST | {"forceinline": True})


def inlined(function: Callable[..., Any]) -> Any:
    """For a few lines that many kernels share: pasted into each caller, which compiles three times faster."""
    return numba.njit(nogil=True, error_model="numpy", inline="always")(function)


def _inside(function: Any, options: dict[str, Any]) -> Any:
    """A function that compiled code takes for its compiled twin, which has no entrance for Python.

    numba's own register_jitable compiles again for every set of options of the callers.
    """
    if config.DISABLE_JIT:
        return function
    function.compiled = numba.njit(no_cpython_wrapper=True, **options)(function)
    function._numba_type_ = function.compiled._numba_type_  # holds it by a weak reference
    return function


def _entry(function: Callable[..., Any], options: dict[str, Any]) -> Any:
    """A compiled function that Python can call; its cache depends on all kernel sources, not on one file's time."""
    if config.DISABLE_JIT:
        return function
    try:
        dispatcher = numba.njit(cache=os.devnull != config.CACHE_DIR, **options)(function)
    except RuntimeError:  # no folder for the cache can be written
        return numba.njit(**options)(function)
    _survive_full_disk(dispatcher._cache)  # noqa: SLF001 numba has no public way to a cache that may fail
    cache_file = getattr(dispatcher._cache, "_cache_file", None)  # noqa: SLF001
    if cache_file is not None and hasattr(cache_file, "_source_stamp"):
        cache_file._source_stamp = sources_digest()  # noqa: SLF001 numba has no public way to set the stamp
    return dispatcher


def _survive_full_disk(kept: Any) -> None:
    """A kernel that the disk does not take is compiled all the same; numba would raise OSError."""
    save = kept.save_overload

    def save_overload(signature: Any, compiled: Any) -> None:
        with suppress(OSError):
            save(signature, compiled)

    kept.save_overload = save_overload
