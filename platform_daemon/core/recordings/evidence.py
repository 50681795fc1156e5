"""Which data a result rests on, so that anybody can repeat it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

from platform_daemon.core.schemas.fits import FileDigest


def file_digests(files: Iterable[Path]) -> tuple[FileDigest, ...]:
    """Name, size and SHA-256 of files; sha256 None for one that is not there any more."""
    return tuple(_digest(Path(f)) for f in files)


def _digest(path: Path) -> FileDigest:
    try:
        with path.open("rb") as file:
            found = hashlib.file_digest(file, "sha256").hexdigest()
        return FileDigest(file=path.name, size_bytes=path.stat().st_size, sha256=found)
    except OSError:
        return FileDigest(file=path.name, size_bytes=None, sha256=None)
