"""The thread that moves the shot gets the processor before everything else, where the computer lets it."""

from __future__ import annotations

import os
from contextlib import suppress

from drivers.clock import Clock

_PRIORITY = 1
"""The lowest of the real-time ones: above every ordinary program, below what the system itself needs."""


def be_urgent(clock: Clock) -> str | None:
    """Let the calling thread go before others (SCHED_RR); None: it does, else why not.

    Only where time passes by itself: a simulation as fast as it goes would take all there is.  Threads that it starts
    from then on go with it: it waits for those that switch outputs off and for the disk.  So do processes, unless they
    `stand_in_line`.
    """
    if not clock.realtime:
        return "its time does not pass by itself"
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(_PRIORITY))
    except (AttributeError, OSError) as error:  # no Linux, or not allowed
        return getattr(error, "strerror", None) or str(error)
    return None


def stand_in_line() -> None:
    """The calling thread is an ordinary one, whoever started it."""
    with suppress(AttributeError):  # no Linux
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
