"""Scheduling priority of the thread that runs a shot: real-time, where the operating system permits it."""

from __future__ import annotations

import os
from contextlib import suppress

from drivers.clock import Clock

_PRIORITY = 1
"""The lowest real-time priority: above every ordinary program, below the kernel's own threads."""


def set_realtime_priority(clock: Clock) -> str | None:
    """Give the calling thread real-time priority (SCHED_RR).  Returns None, or why it was not granted.

    A clock that does not pass by itself is refused: a simulation without pauses would take the whole processor.
    Threads and processes that the thread starts later inherit the priority, because it waits for those that switch
    outputs off and that write to the disk; a process gives it up by `set_ordinary_priority`.
    """
    if not clock.realtime:
        return "its time does not pass by itself"
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(_PRIORITY))
    except (AttributeError, OSError) as error:  # no Linux, or not allowed
        return getattr(error, "strerror", None) or str(error)
    return None


def set_ordinary_priority() -> None:
    """Give the calling thread ordinary priority (SCHED_OTHER), if it has inherited that of `set_realtime_priority`.

    One that runs when nobody else does (SCHED_IDLE) stays so: few accounts may leave that.
    """
    with suppress(AttributeError):  # no Linux
        if os.sched_getscheduler(0) in (os.SCHED_RR, os.SCHED_FIFO):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
