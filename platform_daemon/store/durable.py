"""Files that are on the disk when the call returns: written aside, fsynced, renamed or linked, folder fsynced."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from secrets import token_hex

from .errors import StorageError

PART = ".part"
"""Suffix of a file that is still being written; whoever finds one after a crash may delete it."""


def write_file(target: Path, content: bytes, mode: int = 0o666) -> None:
    """`target` with `content`, whole or not at all, in the place of what was there; mode: of the file, less the umask.

    Raises StorageError; no part file stays behind then, nor what another thread or process writes at the same time.
    """
    part = _part_of(target)
    try:
        with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, mode), "wb") as file:
            file.write(content)
        publish(part, target)
    except OSError as error:
        raise storage_error(target, error) from error
    finally:
        with suppress(OSError):
            part.unlink()


def write_new_file(target: Path, content: bytes) -> bool:
    """The same, but never in the place of another file: False if there is one.  Raises StorageError."""
    part = _part_of(target)
    try:
        part.write_bytes(content)
        sync(part)
        os.link(part, target)  # unlike a rename it never replaces
        sync(target.parent)
    except FileExistsError:
        return False
    except OSError as error:
        raise storage_error(target, error) from error
    finally:
        with suppress(OSError):
            part.unlink()
    return True


def _part_of(target: Path) -> Path:
    return target.with_name(f".{target.name}.{os.getpid()}-{token_hex(4)}{PART}")


def reserve(part: Path, content: bytes, size: int) -> None:
    """Begin a part file with `content` on `size` bytes of disk that are already its own.  Raises OSError if full."""
    with part.open("wb") as file:
        file.write(content)
        file.flush()
        os.posix_fallocate(file.fileno(), 0, size)


def publish(part: Path, target: Path) -> None:
    """Make a finished part file appear as `target` by one rename, durable before and after.  Raises OSError."""
    sync(part)
    os.replace(part, target)
    sync(target.parent)


def sync(path: Path) -> None:
    """Have a file or folder on the disk.  Raises OSError."""
    fd = os.open(path, os.O_RDONLY)
    try:
        os.fsync(fd)
    finally:
        os.close(fd)


def storage_error(path: Path, error: Exception) -> StorageError:
    """The error for a disk that refused."""
    why = (str(error).splitlines() or [type(error).__name__])[0]
    remedy = "free or repair the disk; shots acknowledged before are safe and are recovered at the next start"
    return StorageError("the disk refused to write", where=str(path), why=why, remedy=remedy)
