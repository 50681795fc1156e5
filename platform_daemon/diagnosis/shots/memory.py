"""Memory of arrays that are freed goes back to the operating system."""

from __future__ import annotations

import ctypes
import sys

from platform_daemon.diagnosis.thresholds import THRESHOLDS

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # M_TRIM_THRESHOLD and M_MMAP_THRESHOLD of <malloc.h>


def give_large_arrays_back() -> None:
    """From now on large arrays of this process go back to the operating system once they are freed.

    glibc puts arrays of up to 32 MB into heaps of its own, one for each thread, whose holes it keeps: of twelve shots
    of 5 s a fifth of the memory was such holes.  A fresh array costs more time for it, a tenth of that diagnosis.  With
    another C library nothing happens.
    """
    if sys.platform != "linux":
        return
    library = ctypes.CDLL(None)
    if hasattr(library, "mallopt") and hasattr(library, "malloc_trim"):
        library.mallopt(_MMAP_THRESHOLD, THRESHOLDS.shots.large_array_bytes)
        library.mallopt(_TRIM_THRESHOLD, THRESHOLDS.shots.kept_heap_bytes)
        library.malloc_trim(0)
