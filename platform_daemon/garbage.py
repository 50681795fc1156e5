"""Python's search for garbage, kept short: it stops all threads, and walks over every object there is.

With the numerical libraries loaded it takes a tenth of a second, which would now and then fall between two shots.
"""

from __future__ import annotations

import gc


def spare_what_is_there() -> None:
    """Search once more, now; from here on only what is made later is walked over."""
    gc.unfreeze()
    gc.collect()
    gc.freeze()
