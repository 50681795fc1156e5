"""The fault latch: a file that keeps power off until a named person has reset it; it survives restarts."""

from __future__ import annotations

import os
from contextlib import suppress
from datetime import UTC, datetime
from enum import StrEnum
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from drivers.errors import DeviceError, InputError, InterlockError
from platform_daemon.core.state.accounts import give_to_owner_of_parent

FAULT_FILE, RESETS_FILE = "faulted.json", "resets.jsonl"
REMEDY = "look at the platform, then `platform-daemon reset-fault --by NAME` or POST /platform/fault/reset"


class Cause(StrEnum):
    """Why the outputs had to be switched off by another process than their owner."""

    DIED = "the program that owned the devices died while power might be on"
    HUNG = "the program that owned the devices hung while power might be on, and was killed"
    TOGETHER = "the program that owned the devices and its guard died together while power might be on"
    UNPROVED = "outputs could not be proved off"
    UNREADABLE = "the lock cannot be read"


class Fault(BaseModel):
    """A fault.

    Attributes:
        platform: name of the platform.
        when: ISO 8601, UTC.
        owner: process id of the owner.
        cause: why the outputs had to be switched off.
        proved: the outputs were read back off afterwards.
        detail: what could not be proved.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    platform: str
    when: str
    owner: int
    cause: Cause
    proved: bool
    detail: str = ""

    def __str__(self) -> str:
        off = "outputs were proved off afterwards" if self.proved else f"outputs were NOT proved off: {self.detail}"
        return f"{self.when}, process {self.owner}: {self.cause}; {off}"


class Reset(BaseModel):
    """Who has cleared a fault, when (ISO 8601, UTC), and why."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    by: str
    when: str
    reason: str
    fault: Fault


def utc_now() -> str:
    """ISO 8601, UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def latched_fault(state_dir: Path) -> Fault | None:
    """The fault that has not been reset; None: there is none.  A file that cannot be read counts as a fault."""
    path = state_dir / FAULT_FILE
    try:
        text = path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        return _unreadable(error.strerror or str(error))
    try:
        return Fault.model_validate_json(text)
    except ValidationError as error:
        return _unreadable(f"{path}: {error.error_count()} errors")


def latch_fault(state_dir: Path, fault: Fault) -> None:
    """Write the fault durably, in the place of an earlier one, which knows less.  Raises OSError."""
    part = state_dir / f".{FAULT_FILE}.{os.getpid()}"
    try:
        state_dir.mkdir(parents=True, exist_ok=True, mode=0o700)  # it may have been removed meanwhile
        with part.open("wb") as file:
            file.write(fault.model_dump_json(indent=1).encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())
        give_to_owner_of_parent(part)
        part.replace(state_dir / FAULT_FILE)
        _sync(state_dir)
    finally:
        with suppress(OSError):
            part.unlink()


def clear_fault(state_dir: Path, by: str, reason: str) -> Fault | None:
    """Record who resets the fault and why, then remove it; the fault, None: there was none.

    The outputs must have been proved off.  Raises InputError without a name, DeviceError if the disk refuses: the fault
    stays then.
    """
    by = person_name(by)
    fault = latched_fault(state_dir)
    if fault is None:
        return None
    line = Reset(by=by, when=utc_now(), reason=reason, fault=fault).model_dump_json().encode() + b"\n"
    try:
        with (state_dir / RESETS_FILE).open("ab") as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())
        give_to_owner_of_parent(state_dir / RESETS_FILE)
        (state_dir / FAULT_FILE).unlink()
        _sync(state_dir)
    except OSError as error:
        why = error.strerror or str(error)
        remedy = "free or repair the disk, then reset again"
        raise DeviceError("the fault could not be cleared", where=str(state_dir), why=why, remedy=remedy) from None
    return fault


def person_name(by: str) -> str:
    """The name of a person, without spaces around it.  Raises InputError if it is empty."""
    if not by.strip():
        raise InputError("a fault is reset by a person", where="by", remedy="say who you are")
    return by.strip()


def check_no_fault(state_dir: Path) -> None:
    """Raises InterlockError while a fault is latched."""
    fault = latched_fault(state_dir)
    if fault is not None:
        error = InterlockError("no power before a named person has reset a fault", why=str(fault), remedy=REMEDY)
        error.nothing_moved = True
        raise error


def _unreadable(detail: str) -> Fault:
    return Fault(platform="", when="at an unknown time", owner=0, cause=Cause.UNREADABLE, proved=False, detail=detail)


def _sync(folder: Path) -> None:
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
