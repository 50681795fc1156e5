"""Memory of arrays that are freed goes back to the operating system."""

from __future__ import annotations

import ctypes
import sys

from platform_daemon.diagnosis.thresholds import THRESHOLDS

_MMAP_THRESHOLD = -3  # M_MMAP_THRESHOLD of <malloc.h>


def give_memory_back() -> None:
    """What was freed goes back to the operating system, and from now on every large array does once it is freed.

    glibc puts arrays of up to 32 MB into heaps of its own, one for each thread, whose holes it keeps: of twelve shots
    of 5 s a third of the memory was such holes.  With another C library nothing happens.
    """
    if sys.platform != "linux":
        return
    library = ctypes.CDLL(None)
    if hasattr(library, "mallopt") and hasattr(library, "malloc_trim"):
        library.mallopt(_MMAP_THRESHOLD, THRESHOLDS.shots.large_array_bytes)
        library.malloc_trim(0)
