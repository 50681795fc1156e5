"""Threads that answer in time: what Python does that would lengthen the time between two shots, kept short.

Its search for garbage stops all threads and walks over every object there is: a tenth of a second with the numerical
libraries loaded.  And a thread that computes lets another one on after 5 ms only, which twenty questions to devices
add up.
"""

from __future__ import annotations

import gc
import math
import sys
import time

TURN_S = 5e-4
"""After this long a thread that computes lets another one on; less costs more in turns than it gains."""
ALL_EVERY_S = 60.0
"""The search walks over what was there before no more often than this: short series one after another need it once."""
_OFTEN = (700, 10, 10)
"""Thresholds of the search, as Python's own: more of them would make each search longer."""
_searched_s = -math.inf


def reduce_latency() -> None:
    """Search for garbage once more, now, and from here on only in what is made later, often and so for a short time;
    turns are short from here on."""
    global _searched_s
    sys.setswitchinterval(TURN_S)
    if time.monotonic() - _searched_s > ALL_EVERY_S:
        gc.unfreeze()
        _searched_s = time.monotonic()
    gc.collect()
    gc.freeze()
    gc.set_threshold(*_OFTEN)
