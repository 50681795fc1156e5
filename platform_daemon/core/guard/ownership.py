"""Ownership of the devices of a platform: one process at a time has it, and leaves a record behind when it dies.

The name of the directory is the name of the devices (`devices_name`).  The owner claims it for this computer
(`drivers.claims`), so that a program of another account, or one that has a `/tmp` and a home of its own, finds the
owner as well.  The file `owner` belongs to the account; its first byte says whether power may be on, and outlives the
owner.  It is locked by flock, for programs of another network namespace with the same directory, and so is the
directory: a program that deletes the file, in the belief that it was left behind, does not become an owner.  The kernel
releases all of them with the last process that holds them: the owner, or the guard that still switches off for it.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import structlog
from pydantic import BaseModel, ConfigDict, ValidationError

from drivers.claims import Claim, Claimed, holder_of
from drivers.errors import ConfigError, DeviceDenied, PlatformError
from drivers.registry import PlatformSection
from platform_daemon.core.state.accounts import give_to_owner_of_parent

from .fault_latch import Cause, Fault, latch_fault, utc_now
from .state_dir import devices_name, state_dir_of

log = structlog.get_logger()
_FILE = "owner"
_POWER, _NONE = b"+", b"-"
_PATIENCE_S = 15.0  # a guard that switches off for a dead owner
_LOOK_PATIENCE_S = 0.5


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
        """A process of that number runs, and the computer has not been restarted since."""
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

    def __init__(self, fd: int, folder: int = -1, claim: Claim | None = None) -> None:
        self.fd = fd
        self._folder = folder
        self._claim = claim
        # A forked child must not hold what its parent owned; a guard inherits it on purpose.
        os.register_at_fork(after_in_child=self._forget)

    @property
    def held(self) -> tuple[int, ...]:
        """The descriptors that a guard must inherit, so that it owns the devices as long as it lives."""
        return tuple(fd for fd in (self.fd, self._folder, -1 if self._claim is None else self._claim.fd) if fd >= 0)

    def power(self, *, may_be_on: bool) -> None:
        """Record whether power may be on, in the file that survives this process and its guard; takes microseconds."""
        os.pwrite(self.fd, _POWER if may_be_on else _NONE, 0)

    def release(self) -> None:
        """Give the ownership up; the devices have been closed with outputs off.  Idempotent."""
        if self.fd >= 0:
            os.ftruncate(self.fd, 0)
            if self._claim is not None:
                self._claim.close()
            self._forget()

    def _forget(self) -> None:
        if self._claim is not None:
            self._claim.forget()
        for fd in (self.fd, self._folder):
            if fd >= 0:
                with contextlib.suppress(OSError):
                    os.close(fd)
        self.fd = self._folder = -1


def take_ownership(
    state_dir: Path, platform: str, data: Path | None = None, patience_s: float = _PATIENCE_S
) -> Ownership:
    """Become the owner.  While the guard of a dead owner switches off, it is waited for.

    An owner that died together with its guard while power might be on leaves a fault.  Raises DeviceDenied if another
    process owns the devices, or the directory cannot be written.
    """
    until = time.monotonic() + patience_s
    record = _record(data)
    claim = _claimed(state_dir.name, state_dir, record, until)
    try:
        fd, folder = _open_record(state_dir / _FILE), _opened(state_dir)
        try:
            while not _locked(fd, folder):
                _refuse_or_wait(_read(fd), until)
            _take_over(state_dir, platform, fd)
            _write(fd, record)
        except BaseException:
            os.close(fd)
            os.close(folder)
            raise
    except PlatformError:
        claim.close()
        raise
    except OSError as error:
        claim.close()
        why = error.strerror or str(error)
        raise DeviceDenied(
            "the owner cannot be kept", where=str(state_dir), why=why, remedy="repair the disk"
        ) from None
    return Ownership(fd, folder, claim)


@contextmanager
def hold_devices(section: PlatformSection) -> Iterator[None]:
    """Hold the devices for a look at them: meanwhile no program becomes their owner.

    What a dead owner has left stays as it is.  Raises DeviceDenied if a process owns them.
    """
    name = devices_name(section)
    claim = _claimed(name, None, _record(None), time.monotonic() + _LOOK_PATIENCE_S)
    try:
        yield
    finally:
        claim.close()


def owner_of_devices(section: PlatformSection) -> Owner | None:
    """The process that owns the devices now, whatever its account; None: there is none.

    Its own state directory is looked at if this account can have one.
    """
    try:
        state_dir = state_dir_of(section)
    except ConfigError:  # the claim needs none
        return _holder(devices_name(section), None)
    return owner_of(state_dir)


def owner_of(state_dir: Path) -> Owner | None:
    """The process that owns the devices now, whatever its account; None: there is none."""
    return _holder(state_dir.name, state_dir) or _local_owner(state_dir)


def _claimed(name: str, state_dir: Path | None, record: Owner, until_s: float) -> Claim:
    """The devices of this name, claimed; until_s: monotonic.  Raises DeviceDenied."""
    while True:
        try:
            return Claim(name, record.model_dump_json().encode())
        except Claimed:
            _refuse_or_wait(_holder(name, state_dir), until_s)
        except OSError as error:
            remedy = "run it where sockets of the family AF_UNIX are allowed, and descriptors are left"
            why = error.strerror or str(error)
            raise DeviceDenied("the devices cannot be claimed", where="platform", why=why, remedy=remedy) from None


def _refuse_or_wait(found: Owner | None, until_s: float) -> None:
    """Wait a moment for the guard of a dead owner.  Raises DeviceDenied if the owner lives, and after `until_s`."""
    if time.monotonic() >= until_s or (found is not None and found.lives):
        raise _denied(found)
    time.sleep(0.05)


def _holder(name: str, state_dir: Path | None) -> Owner | None:
    """The process that has claimed this name; what is known of one that does not answer."""
    holder = holder_of(name)
    if holder is None:
        return None
    if holder.record is not None:
        with contextlib.suppress(ValidationError):
            return Owner.model_validate_json(holder.record)
    local = None if state_dir is None else _local_owner(state_dir)
    if local is not None and local.pid == holder.pid:
        return local
    program = f"of the account {holder.account}, which does not answer"
    return Owner(pid=holder.pid, boot=_boot(), program=program, since="an unknown time")


def _local_owner(state_dir: Path) -> Owner | None:
    """The process that holds the file of this account; None: there is none, or its record cannot be read."""
    try:
        fd = _to_look_at(state_dir / _FILE)
    except FileNotFoundError:
        return None
    folder = _opened(state_dir)
    try:
        return None if _locked(fd, folder) else _read(fd)
    finally:
        os.close(fd)
        os.close(folder)


def _to_look_at(path: Path) -> int:
    """The file, for reading alone where this account, or its disk, allows no more.  Raises OSError."""
    try:
        return os.open(path, os.O_RDWR | os.O_CLOEXEC)  # which locks over a network need
    except OSError as error:
        if error.errno not in (errno.EROFS, errno.EACCES):
            raise
        return os.open(path, os.O_RDONLY | os.O_CLOEXEC)


def _opened(state_dir: Path) -> int:
    return os.open(state_dir, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)


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


def _take_over(state_dir: Path, platform: str, fd: int) -> None:
    """Handle the record of a dead owner.  Raises OSError."""
    left = os.pread(fd, 4096, 0)
    if not left:
        return
    before = _read(fd)
    log.warning("dead_owner_taken_over", owner=str(before), power=left[:1] == _POWER)
    if left[:1] != _NONE:
        pid = 0 if before is None else before.pid
        detail = "the next owner proves it before anything else"
        latch_fault(
            state_dir,
            Fault(platform=platform, when=utc_now(), owner=pid, cause=Cause.TOGETHER, proved=False, detail=detail),
        )


def _record(data: Path | None) -> Owner:
    """What this process says of itself; data: its data folder."""
    program = " ".join(sys.argv[1:2]) or "python"
    folder = None if data is None else str(data.resolve())
    return Owner(pid=os.getpid(), boot=_boot(), program=program, since=utc_now(), data=folder)


def _open_record(path: Path) -> int:
    """The file of the owner, made if missing.  Raises OSError."""
    try:
        fd = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    except FileExistsError:
        return os.open(path, os.O_RDWR | os.O_CLOEXEC)
    give_to_owner_of_parent(path)
    return fd


def _write(fd: int, owner: Owner) -> None:
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
        "the devices of this platform have an owner",
        where="platform",
        why=f"it is {who}",
        remedy="end it, or wait until it has ended",
    )
    error.nothing_moved = True
    return error
