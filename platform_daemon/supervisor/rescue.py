"""Outputs off by other hands than their owner's, proved, and written down."""

from __future__ import annotations

import os
import time
from pathlib import Path

from drivers.errors import DeviceDenied, OutputsUnconfirmed, PlatformError
from drivers.outputs_off import switch_outputs_off
from drivers.registry import PlatformSection

from .lock_file import Cause, Fault, clear, lock, named, now
from .ownership import Ownership, take
from .places import place_of
from .say import say

_TRIES_S = (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 10.0)


def rescue(section: PlatformSection, place: Path, owner: int, cause: Cause, ownership: Ownership) -> bool:
    """Switch off for an owner that has died, again and again; the fault is on the disk after the first try.

    True if outputs were proved off at last.
    """
    began, recorded, fault = time.monotonic(), False, None
    for wait_s in _TRIES_S:
        time.sleep(wait_s)
        detail = ""
        try:
            switch_outputs_off(section)
        except Exception as error:  # whatever it is: tried again
            detail = str(error) or type(error).__name__
            say("outputs_unconfirmed", error=detail)
        else:
            took_s = round(time.monotonic() - began, 3)
            say("outputs_switched_off_for_a_dead_owner", owner=owner, seconds=took_s)
        when = now() if fault is None else fault.when
        fault = Fault(platform=section.name, when=when, owner=owner, cause=cause, proved=not detail, detail=detail)
        recorded = _recorded(place, fault) or recorded
        if not detail:
            break
    if recorded:  # else the next owner finds that power might be on, and locks
        ownership.power(may_be_on=False)
    return fault is not None and fault.proved


def outputs_off(section: PlatformSection, patience_s: float = 0.5) -> None:
    """Switch all outputs off while no owner lives, and prove it.  A fault that stands, stands; a failure is one.

    Raises DeviceDenied if an owner lives, OutputsUnconfirmed, ConfigError.
    """
    ownership: Ownership | None = None
    try:
        place = place_of(section)
        ownership = take(place, section.name, None, patience_s)
    except PlatformError as error:
        if isinstance(error, DeviceDenied) and error.nothing_moved:
            raise
        say("owner_not_kept", error=str(error))  # a full or read-only disk must not keep an amplifier enabled
    try:
        switch_outputs_off(section)
    except OutputsUnconfirmed as error:
        unproved = Fault(
            platform=section.name, when=now(), owner=os.getpid(), cause=Cause.UNPROVED, proved=False, detail=str(error)
        )
        if ownership is not None:
            _recorded(place, unproved)
        raise
    finally:
        if ownership is not None:
            ownership.release()


def reset_fault(section: PlatformSection, by: str, reason: str) -> Fault | None:
    """Prove the outputs off while no owner lives, then clear the fault; what stood, None: nothing did.

    Raises DeviceDenied if an owner lives, InputError without a name, OutputsUnconfirmed: the fault stands then.
    """
    by = named(by)
    outputs_off(section)
    return clear(place_of(section), by, reason)


def _recorded(place: Path, fault: Fault) -> bool:
    try:
        lock(place, fault)
    except OSError as error:
        say("fault_not_recorded", error=str(error))
        return False
    return True
