"""The decorator of all numba kernels of the simulated world, with a cache that notices a change in any of them.

numba's own cache compares the file of the outermost function only: after a change in `torque.py` it would silently use
a `motion.march` that was compiled from the old torque.  Here the stamp of a cached kernel is the content of all kernel
files, and of that with their constants, so that a stale kernel is never used, and an unchanged one survives a fresh
check-out.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import config

FOLDER = Path(__file__).parents[1]
FILES = (
    "receive/chain.py",
    "rotor/collocation.py",
    "rotor/extra_torque.py",
    "rotor/internal_state.py",
    "rotor/kernel.py",
    "rotor/motion.py",
    "rotor/pieces.py",
    "rotor/rest.py",
    "rotor/rigid_body/acceleration.py",
    "rotor/rigid_body/integrator.py",
    "rotor/rigid_body/motion.py",
    "rotor/rotor.py",
    "rotor/torque.py",
    "rotor/trajectory.py",
)


def stamp(folder: Path) -> tuple[str, int]:
    """Digest and total length of all kernel files in a folder."""
    content = b"".join((folder / name).read_bytes() for name in FILES)
    return hashlib.sha256(content).hexdigest(), len(content)


STAMP = stamp(FOLDER)


def kernel(function: Callable[..., Any]) -> Any:
    """Compile on first use, release the GIL, keep the result on disk under the common stamp, if it takes files."""
    if config.DISABLE_JIT or os.devnull == config.CACHE_DIR:  # plain Python, for debuggers and coverage; or no files
        return njit(nogil=True)(function)
    try:
        dispatcher = njit(cache=True, nogil=True)(function)
    except RuntimeError:  # no folder for the cache can be written
        return njit(nogil=True)(function)
    kept = dispatcher._cache  # noqa: SLF001 numba has no public way to a stamp of one's own
    kept._cache_file._source_stamp = STAMP  # noqa: SLF001
    save = kept.save_overload

    def save_overload(signature: Any, compiled: Any) -> None:
        with suppress(OSError):  # of a full disk
            save(signature, compiled)

    kept.save_overload = save_overload
    return dispatcher
