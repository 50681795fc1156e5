"""The thread that moves the shot gets the processor before everything else, where the computer lets it."""

from __future__ import annotations

import os

from drivers.clock import Clock

_PRIORITY = 1
"""The lowest of the real-time ones: above every ordinary program, below what the system itself needs."""


def be_urgent(clock: Clock) -> str | None:
    """Let the calling thread go before others (SCHED_RR); None: it does, else why not.

    Only where time passes by itself: a simulation as fast as it goes would take all there is.  Threads and processes
    that it starts are ordinary ones.
    """
    if not clock.realtime:
        return "its time does not pass by itself"
    try:
        os.sched_setscheduler(0, os.SCHED_RR | os.SCHED_RESET_ON_FORK, os.sched_param(_PRIORITY))
    except (AttributeError, OSError) as error:  # no Linux, or not allowed
        return getattr(error, "strerror", None) or str(error)
    return None
