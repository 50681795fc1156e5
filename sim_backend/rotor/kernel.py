"""The decorator of all numba kernels of the simulated world, with a cache that notices a change in any of them.

numba's own cache looks at the file of the outermost function only: after a change in `torque.py` it would go on using a
`motion.march` compiled from the old torque, silently.  Here the stamp of a cached kernel is the content of all kernel
files, so a stale one is never used, and an unchanged one survives a fresh check-out.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit

FOLDER = Path(__file__).parents[1]
FILES = (
    "receive/chain.py",
    "rotor/collocation.py",
    "rotor/extra_torque.py",
    "rotor/hidden.py",
    "rotor/kernel.py",
    "rotor/motion.py",
    "rotor/rest.py",
    "rotor/rigid_body/acceleration.py",
    "rotor/rigid_body/integrator.py",
    "rotor/rigid_body/motion.py",
    "rotor/torque.py",
    "rotor/trajectory.py",
)


def stamp(folder: Path) -> tuple[str, int]:
    """Digest and total length of all kernel files in a folder."""
    content = b"".join((folder / name).read_bytes() for name in FILES)
    return hashlib.sha256(content).hexdigest(), len(content)


STAMP = stamp(FOLDER)


def kernel(function: Callable[..., Any]) -> Any:
    """Compile on first use, release the GIL, keep the result on disk under the common stamp."""
    dispatcher = njit(cache=True, nogil=True)(function)
    dispatcher._cache._cache_file._source_stamp = STAMP  # noqa: SLF001 numba has no public way to a stamp of one's own
    return dispatcher
