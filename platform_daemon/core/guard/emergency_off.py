"""Outputs off by another process than their owner, proved and recorded."""

from __future__ import annotations

import contextlib
import os
import time
from pathlib import Path

from drivers.errors import DeviceDenied, OutputsUnconfirmed, PlatformError
from drivers.outputs_off import switch_outputs_off
from drivers.registry import PlatformSection

from .fault_latch import Cause, Fault, clear_fault, latch_fault, person_name, utc_now
from .ownership import Ownership, hold_devices, take_ownership
from .state_dir import state_dir_of
from .stderr_log import log_event

_TRIES_S = (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 10.0)


def switch_off_for_dead_owner(
    section: PlatformSection, *, state_dir: Path, owner: int, cause: Cause, ownership: Ownership
) -> bool:
    """Switch the outputs off for an owner that has died, with retries; the fault is on the disk after the first try.

    owner: its process id; ownership: what the guard holds for it.  True if the outputs were proved off at last.
    """
    began = time.monotonic()
    recorded = False
    fault = None
    for wait_s in _TRIES_S:
        time.sleep(wait_s)
        detail = ""
        try:
            switch_outputs_off(section)
        except Exception as error:  # whatever it is, the next try may succeed
            detail = str(error) or type(error).__name__
            log_event("outputs_unconfirmed", error=detail)
        else:
            took_s = round(time.monotonic() - began, 3)
            log_event("outputs_switched_off_for_a_dead_owner", owner=owner, seconds=took_s)
        when = utc_now() if fault is None else fault.when
        fault = Fault(platform=section.name, when=when, owner=owner, cause=cause, proved=not detail, detail=detail)
        recorded = _record(state_dir, fault) or recorded
        if not detail:
            break
    if recorded:  # else the next owner finds that power might be on, and latches a fault
        ownership.power(may_be_on=False)
    return fault is not None and fault.proved


def outputs_off(section: PlatformSection, patience_s: float = 0.5) -> None:
    """Switch all outputs off while no owner lives, and prove it.  A latched fault stays; a failure latches one.

    Raises DeviceDenied if an owner lives, OutputsUnconfirmed, ConfigError.
    """
    with contextlib.ExitStack() as held:
        state_dir = _hold(section, patience_s, held)
        try:
            switch_outputs_off(section)
        except OutputsUnconfirmed as error:
            unproved = Fault(
                platform=section.name,
                when=utc_now(),
                owner=os.getpid(),
                cause=Cause.UNPROVED,
                proved=False,
                detail=str(error),
            )
            if state_dir is not None:
                _record(state_dir, unproved)
            raise


def _hold(section: PlatformSection, patience_s: float, held: contextlib.ExitStack) -> Path | None:
    """Own the devices; the directory of their state, None if it cannot be used, which must not keep an amplifier
    enabled.  Raises DeviceDenied if an owner lives."""
    try:
        state_dir = state_dir_of(section)
        held.callback(take_ownership(state_dir, section.name, None, patience_s).release)
    except PlatformError as error:
        _log_unless_owned(error)
    else:
        return state_dir
    try:
        held.enter_context(hold_devices(section))
    except DeviceDenied as error:
        _log_unless_owned(error)
    return None


def _log_unless_owned(error: PlatformError) -> None:
    if isinstance(error, DeviceDenied) and error.nothing_moved:
        raise error
    log_event("owner_not_kept", error=str(error))


def reset_fault(section: PlatformSection, by: str, reason: str) -> Fault | None:
    """Prove the outputs off while no owner lives, then clear the fault; the fault, None: there was none.

    Raises DeviceDenied if an owner lives, InputError without a name, OutputsUnconfirmed: the fault stays then.
    """
    by = person_name(by)
    outputs_off(section)
    return clear_fault(state_dir_of(section), by, reason)


def _record(state_dir: Path, fault: Fault) -> bool:
    try:
        latch_fault(state_dir, fault)
    except OSError as error:
        log_event("fault_not_recorded", error=str(error))
        return False
    return True
