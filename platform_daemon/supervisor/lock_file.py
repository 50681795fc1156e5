"""The durable lock: what stands in the way of power until a named person has reset it."""

from __future__ import annotations

import os
from contextlib import suppress
from datetime import UTC, datetime
from enum import StrEnum
from pathlib import Path

from pydantic import BaseModel, ConfigDict, ValidationError

from drivers.errors import DeviceError, InputError, InterlockError

FAULTED, HISTORY = "faulted.json", "resets.jsonl"
REMEDY = "look at the platform, then `platform-daemon reset-fault --by NAME` or POST /platform/fault/reset"


class Cause(StrEnum):
    """Why the outputs had to be switched off by somebody else than their owner."""

    DIED = "the program that owned the devices died while power might be on"
    HUNG = "the program that owned the devices hung while power might be on, and was killed"
    TOGETHER = "the program that owned the devices and its guard died together while power might be on"
    UNPROVED = "outputs could not be proved off"
    UNREADABLE = "the lock cannot be read"


class Fault(BaseModel):
    """What happened; when: ISO 8601, UTC; owner: process id; proved: outputs were read back off after it; detail: what
    could not be proved."""

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


def now() -> str:
    """ISO 8601, UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def standing(place: Path) -> Fault | None:
    """The fault that nobody has reset; None: there is none.  A file that cannot be read stands, too."""
    path = place / FAULTED
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


def lock(place: Path, fault: Fault) -> None:
    """On the disk when it returns.  One that stands is replaced: the newer one knows more.  Raises OSError."""
    part = place / f".{FAULTED}.{os.getpid()}"
    try:
        place.mkdir(parents=True, exist_ok=True, mode=0o700)  # somebody may have tidied it up meanwhile
        with part.open("wb") as file:
            file.write(fault.model_dump_json(indent=1).encode() + b"\n")
            file.flush()
            os.fsync(file.fileno())
        part.replace(place / FAULTED)
        _sync(place)
    finally:
        with suppress(OSError):
            part.unlink()


def clear(place: Path, by: str, reason: str) -> Fault | None:
    """What stood, after it is gone; written down first.  Outputs must have been proved off.  None: nothing stood.

    Raises InputError without a name, DeviceError if the disk refuses: the lock stands then.
    """
    by, fault = named(by), standing(place)
    if fault is None:
        return None
    line = Reset(by=by, when=now(), reason=reason, fault=fault).model_dump_json().encode() + b"\n"
    try:
        with (place / HISTORY).open("ab") as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())
        (place / FAULTED).unlink()
        _sync(place)
    except OSError as error:
        why = error.strerror or str(error)
        remedy = "free or repair the disk, then reset again"
        raise DeviceError("the lock could not be cleared", where=str(place), why=why, remedy=remedy) from None
    return fault


def named(by: str) -> str:
    """The name of a person.  Raises InputError if it is empty."""
    if not by.strip():
        raise InputError("a fault is reset by a person", where="by", remedy="say who you are")
    return by.strip()


def refuse(place: Path) -> None:
    """Raises InterlockError while a fault stands."""
    fault = standing(place)
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
