"""The audit log of a data folder: one JSON line for everything that changes what the platform does."""

from __future__ import annotations

import errno
import os
import threading
from pathlib import Path

from platform_daemon.schemas import AuditEntry, to_json

from .durable import storage_error


class AuditLog:
    """Lines are only ever appended, and are on the disk when `append` returns."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()

    def append(self, entry: AuditEntry) -> None:
        """Add a line.  Raises StorageError if the disk refuses."""
        line = f"{to_json(entry)}\n".encode()
        try:
            with self._lock:
                # One write to a file opened for appending: lines of two processes never mix.
                file = os.open(self.path, os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
                try:
                    _write(file, line)
                    os.fsync(file)
                finally:
                    os.close(file)
        except OSError as error:
            raise storage_error(self.path, error) from error

    def entries(self) -> tuple[AuditEntry, ...]:
        """All lines, oldest first; one that was cut off by a power failure is left out.  Raises OSError."""
        if not self.path.exists():
            return ()
        found = []
        for line in self.path.read_text(encoding="utf-8").splitlines():
            try:
                found.append(AuditEntry.model_validate_json(line))
            except ValueError:
                continue
        return tuple(found)


def _write(file: int, line: bytes) -> None:
    """At the end, on a line of its own whatever a disk that was full has left there.  Raises OSError."""
    end = os.fstat(file).st_size
    if end and os.pread(file, 1, end - 1) != b"\n":
        line = b"\n" + line
    if os.write(file, line) < len(line):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
