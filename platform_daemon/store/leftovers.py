"""What kills leave behind: part files of writers that are dead, and shots that were never put together."""

from __future__ import annotations

import re
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from .durable import PART
from .errors import NotAssembled
from .index import Broken
from .staging import SUFFIX, claim_abandoned

_PART = re.compile(rf"\..*\.((?P<pid>[0-9]+)-)?[0-9a-f]{{8}}{re.escape(PART)}")
_LONG_S = 3600.0
"""No file takes so long to write: whoever has the writer's process id now is somebody else."""


def sweep(folders: Iterable[Path]) -> list[Path]:
    """Delete part files whose writers are dead; those deleted.  Never a file that was acknowledged."""
    swept = []
    for path in (path for folder in folders for path in folder.glob(f".*{PART}")):
        named = _PART.fullmatch(path.name)
        if named is None:
            continue
        with suppress(OSError):
            if time.time() - path.stat().st_mtime > _LONG_S or _is_dead(named["pid"]):
                path.unlink()
                swept.append(path)
    return swept


def _is_dead(pid: str | None) -> bool:
    """Of a name without a process id nobody knows."""
    return pid is not None and not Path("/proc", pid).exists()


def kept_series(folder: Path) -> list[Broken]:
    """Series whose shots are safe but were never put together, and that nobody writes to."""
    found = []
    for path in sorted(folder.glob(f".*{SUFFIX}")):
        staging = claim_abandoned(path)
        if staging is None:
            continue
        try:
            shots = len(staging.shots())
            if shots:
                found.append(Broken(staging.target.stem, staging.target, not_assembled(path, shots)))
        finally:
            staging.release()
    return found


def not_assembled(staging: Path, shots: int, why: str = "") -> NotAssembled:
    """The error for shots that are safe in their staging folder."""
    return NotAssembled(
        f"{shots} acknowledged shots are kept, but not put together",
        where=str(staging),
        why=why,
        remedy="free or repair the disk, then POST /recordings/recover, or start the daemon again",
    )
