"""Who owns the devices of a platform: one process at a time, and what it left behind when it is gone.

The file `owner` is held by flock, which the kernel gives up with the last process that has it: the owner, or the guard
that still switches off for it.  Its first byte says whether power may be on; it outlives both.  Its folder is held
in the same way: whoever takes the file for one that was left behind, and removes it, owns nothing.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import sys
import time
from pathlib import Path

import structlog
from pydantic import BaseModel, ConfigDict, ValidationError

from drivers.errors import DeviceDenied

from .lock_file import Cause, Fault, lock, now

log = structlog.get_logger()
_FILE = "owner"
_POWER, _NONE = b"+", b"-"
_PATIENCE_S = 15.0  # a guard that switches off for a dead owner


class Owner(BaseModel):
    """A process that owns the devices; boot: id of the start of the computer; data: its data folder, if it has one."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    pid: int
    boot: str
    program: str
    since: str
    data: str | None = None

    def __str__(self) -> str:
        return f"process {self.pid} ({self.program}) since {self.since}"

    @property
    def lives(self) -> bool:
        """A process of that number runs, and the computer has not been started anew since."""
        if self.boot != _boot():
            return False
        try:
            os.kill(self.pid, 0)
        except ProcessLookupError:
            return False
        except PermissionError:
            return True  # another account's
        return True


class Ownership:
    """Held until `release` or the death of this process and its guard."""

    def __init__(self, fd: int, folder: int = -1) -> None:
        self.fd, self._folder = fd, folder
        # A child that is forked must not hold what its parent owned; a guard gets it on purpose.
        os.register_at_fork(after_in_child=self._drop)

    @property
    def held(self) -> tuple[int, ...]:
        """What a guard must have open, so that it owns the devices as long as it lives."""
        return tuple(fd for fd in (self.fd, self._folder) if fd >= 0)

    def power(self, *, may_be_on: bool) -> None:
        """Kept where a kill of this process and its guard together does not reach it; microseconds."""
        os.pwrite(self.fd, _POWER if may_be_on else _NONE, 0)

    def release(self) -> None:
        """The devices have been let go with outputs off.  Idempotent."""
        if self.fd >= 0:
            os.ftruncate(self.fd, 0)
            self._drop()

    def _drop(self) -> None:
        for fd in self.held:
            with contextlib.suppress(OSError):
                os.close(fd)
        self.fd = self._folder = -1


def take(place: Path, platform: str, data: Path | None = None, patience_s: float = _PATIENCE_S) -> Ownership:
    """Become the owner; one that is dead is waited for while its guard switches off, and then taken over.

    An owner that died together with its guard while power might be on leaves a fault.  Raises DeviceDenied if another
    process owns the devices, or the place cannot be written.
    """
    until = time.monotonic() + patience_s
    try:
        fd, folder = os.open(place / _FILE, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600), _opened(place)
        try:
            while not _locked(fd, folder):
                found = _read(fd)
                if time.monotonic() >= until or (found is not None and found.lives):
                    raise _denied(found)
                time.sleep(0.05)
            _take_over(place, platform, fd)
            _write(fd, data)
        except BaseException:
            os.close(fd)
            os.close(folder)
            raise
    except OSError as error:
        why = error.strerror or str(error)
        raise DeviceDenied("the owner cannot be kept", where=str(place), why=why, remedy="repair the disk") from None
    return Ownership(fd, folder)


def owner_of(place: Path) -> Owner | None:
    """Who owns the devices now; None: nobody does, or it cannot be read any more."""
    try:
        fd = os.open(place / _FILE, os.O_RDWR | os.O_CLOEXEC)
    except FileNotFoundError:
        return None
    folder = _opened(place)
    try:
        return None if _locked(fd, folder) else _read(fd)
    finally:
        os.close(fd)
        os.close(folder)


def _opened(place: Path) -> int:
    return os.open(place, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)


def _locked(fd: int, folder: int) -> bool:
    try:
        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno != errno.EBADF:  # NFS locks only what is open for writing, which the folder cannot be
            raise
    return True


def _take_over(place: Path, platform: str, fd: int) -> None:
    """What a dead owner left.  Raises OSError."""
    left = os.pread(fd, 4096, 0)
    if not left:
        return
    before = _read(fd)
    log.warning("dead_owner_taken_over", owner=str(before), power=left[:1] == _POWER)
    if left[:1] != _NONE:
        pid = 0 if before is None else before.pid
        detail = "the next owner proves it before anything else"
        lock(place, Fault(platform=platform, when=now(), owner=pid, cause=Cause.TOGETHER, proved=False, detail=detail))


def _write(fd: int, data: Path | None) -> None:
    program = " ".join(sys.argv[1:2]) or "python"
    folder = None if data is None else str(data.resolve())
    owner = Owner(pid=os.getpid(), boot=_boot(), program=program, since=now(), data=folder)
    os.ftruncate(fd, 0)
    os.pwrite(fd, _NONE + owner.model_dump_json().encode() + b"\n", 0)
    os.fsync(fd)


def _read(fd: int) -> Owner | None:
    try:
        return Owner.model_validate_json(os.pread(fd, 4096, 0)[1:])
    except ValidationError:
        return None


def _boot() -> str:
    return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()


def _denied(found: Owner | None) -> DeviceDenied:
    who = "another process" if found is None else str(found)
    if found is not None and not found.lives:
        who = f"the guard of {found}, which has died: it still tries to switch the outputs off"
    error = DeviceDenied(
        "the devices of this platform have an owner", where="platform", why=f"it is {who}",
        remedy="end it, or wait until it has ended",
    )  # fmt: skip
    error.nothing_moved = True
    return error
