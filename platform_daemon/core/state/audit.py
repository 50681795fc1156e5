"""The audit log of a data folder: one JSON line for everything that changes what the platform does."""

from __future__ import annotations

import errno
import os
import threading
from collections.abc import Iterable
from pathlib import Path

from platform_daemon.core.schemas.access import AuditEntry
from platform_daemon.core.schemas.base import to_json

from .accounts import give_to_owner_of_parent
from .durable import storage_error

AUDIT = "audit.jsonl"
"""Name of the file in a data folder."""


_BLOCK = 65536


class AuditLog:
    """The audit log at `path`.  Lines are only ever appended, and are on the disk when `append` returns."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()

    def append(self, entry: AuditEntry) -> None:
        """Append a line.  Raises StorageError if the disk refuses."""
        line = f"{to_json(entry)}\n".encode()
        try:
            with self._lock:
                # One write to a file opened for appending: lines of two processes never mix.
                file = os.open(self.path, os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
                try:
                    give_to_owner_of_parent(self.path)
                    _write(file, line)
                    os.fsync(file)
                finally:
                    os.close(file)
        except OSError as error:
            raise storage_error(self.path, error) from error

    def entries(self) -> tuple[AuditEntry, ...]:
        """All lines, oldest first; one that was cut off by a power failure is left out.  Raises OSError."""
        return tuple(_entries(self.path.read_bytes().splitlines())) if self.path.exists() else ()

    def newest(self, limit: int, before: int | None = None) -> tuple[tuple[AuditEntry, ...], int]:
        """At most `limit` lines, newest first, and the place in the file where the oldest of them begins, 0: there are
        no older ones.  Lines that were cut off by a power failure are left out.  Raises OSError.

        before: such a place; None: the end of the file.
        """
        try:
            with self.path.open("rb") as file:
                end = file.seek(0, os.SEEK_END)
                begin = end = end if before is None else min(before, end)
                tail = b""
                while begin and tail.count(b"\n") <= limit:  # one more: the first line may be a part of one
                    size = min(begin, _BLOCK)
                    begin = file.seek(begin - size)
                    tail = file.read(size) + tail
        except FileNotFoundError:
            return (), 0
        lines = tail.splitlines(keepends=True)[-limit:]
        return tuple(reversed(_entries(lines))), end - sum(map(len, lines))


def audit_log_in(folder: Path) -> AuditLog:
    """The audit log of a data folder, which a daemon may have open."""
    return AuditLog(folder / AUDIT)


def _write(file: int, line: bytes) -> None:
    """Append a line, after a line break if a full disk has cut the last one off.  Raises OSError."""
    end = os.fstat(file).st_size
    if end and os.pread(file, 1, end - 1) != b"\n":
        line = b"\n" + line
    if os.write(file, line) < len(line):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _entries(lines: Iterable[bytes]) -> list[AuditEntry]:
    found = []
    for line in lines:
        try:
            found.append(AuditEntry.model_validate_json(line))
        except ValueError:
            continue
    return found
