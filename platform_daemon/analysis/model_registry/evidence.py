"""What is kept with an adopted model so that anybody can judge it, or repeat the diagnosis."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from platform_daemon import __version__


def file_digests(files: Iterable[Path]) -> list[dict[str, Any]]:
    """Name, size and SHA-256 of files; sha256 None for one that is not there any more."""
    return [_digest(Path(f)) for f in files]


def _digest(path: Path) -> dict[str, Any]:
    try:
        with path.open("rb") as file:
            found = hashlib.file_digest(file, "sha256").hexdigest()
        return {"file": path.name, "size_bytes": path.stat().st_size, "sha256": found}
    except OSError:
        return {"file": path.name, "size_bytes": None, "sha256": None}


def provenance(by: str) -> dict[str, Any]:
    """Who, when and with which software."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    return {"adopted_by": by, "adopted_at": now, "software_version": __version__}
