"""Files that are on the disk when the call returns.

The content is written to a part file next to the target and synced; then the part file is renamed, or linked where no
other file may be replaced, to the name of the target, and the folder is synced.  A reader finds the old content or the
new one; a crash leaves at most a part file, which `sweep` deletes.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from secrets import token_hex

from .accounts import give_to_owner_of_parent
from .errors import StorageError

PART = ".part"
"""Suffix of a file that is still being written; one that is left after a crash may be deleted."""
_PART = re.compile(rf"\..*\.((?P<pid>[0-9]+)-)?[0-9a-f]{{8}}{re.escape(PART)}")
_LONG_S = 3600.0
"""No file takes so long to write: an older part file whose process id is alive belongs to another process by now."""


def write_file(target: Path, content: bytes, mode: int = 0o666) -> None:
    """Write `content` to `target`, whole or not at all, in the place of what was there.

    mode: permissions of the file, less the umask; one that root writes belongs to the owner of the folder.  Any number
    of threads and processes may write one target: the last rename wins.  Raises StorageError, and leaves no part file
    behind then.
    """
    part = part_of(target)
    try:
        with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, mode), "wb") as file:
            file.write(content)
        give_to_owner_of_parent(part)
        publish(part, target)
    except OSError as error:
        raise storage_error(target, error) from error
    finally:
        with suppress(OSError):
            part.unlink()


def write_new_file(target: Path, content: bytes) -> bool:
    """Write `content` to `target` unless there is such a file, then return False.  Raises StorageError."""
    part = part_of(target)
    try:
        part.write_bytes(content)
        return publish_new(part, target)
    except OSError as error:
        raise storage_error(target, error) from error
    finally:
        with suppress(OSError):
            part.unlink()


def part_of(target: Path) -> Path:
    """A name for the part file of `target` that no other thread or process uses."""
    return target.with_name(f".{target.name}.{os.getpid()}-{token_hex(4)}{PART}")


def reserve(part: Path, content: bytes, size: int) -> None:
    """Begin a part file with `content`, with `size` bytes of the disk allocated to it.  Raises OSError if full."""
    with part.open("wb") as file:
        file.write(content)
        file.flush()
        os.posix_fallocate(file.fileno(), 0, size)


def publish(part: Path, target: Path) -> None:
    """Rename a finished part file to `target`; content and name are on the disk on return.  Raises OSError."""
    sync(part)
    os.replace(part, target)
    sync(target.parent)


def publish_new(part: Path, target: Path) -> bool:
    """The same unless there is such a file, then return False; the part file stays.  Raises OSError."""
    sync(part)
    try:
        os.link(part, target)  # unlike a rename it never replaces
    except FileExistsError:
        return False
    sync(target.parent)
    return True


def sweep(folders: Iterable[Path], pattern: str = f".*{PART}") -> list[Path]:
    """Delete part files whose writers are dead; returns them.  A file that was acknowledged is never deleted."""
    swept = []
    for path in (path for folder in folders for path in folder.glob(pattern)):
        named = _PART.fullmatch(path.name)
        if named is None:
            continue
        with suppress(OSError):
            if time.time() - path.stat().st_mtime > _LONG_S or _is_dead(named["pid"]):
                path.unlink()
                swept.append(path)
    return swept


def _is_dead(pid: str | None) -> bool:
    """Whether the process has ended; False for a name without a process id."""
    return pid is not None and not Path("/proc", pid).exists()


def sync(path: Path) -> None:
    """Flush a file or folder to the disk.  Raises OSError."""
    fd = os.open(path, os.O_RDONLY)
    try:
        os.fsync(fd)
    finally:
        os.close(fd)


def storage_error(path: Path, error: Exception) -> StorageError:
    """The error to raise where the disk refused to write `path`."""
    why = (str(error).splitlines() or [type(error).__name__])[0]
    remedy = "free or repair the disk; shots acknowledged before are safe and are recovered at the next start"
    return StorageError("the disk refused to write", where=str(path), why=why, remedy=remedy)
