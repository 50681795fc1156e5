"""Shots that a killed process acknowledged and never assembled to a recording."""

from __future__ import annotations

from pathlib import Path

from platform_daemon.core.state.errors import NotAssembled

from .index import Broken
from .staging import SUFFIX, claim_abandoned


def kept_series(folder: Path) -> list[Broken]:
    """Series whose shots are on disk but were not assembled, and that no process writes to."""
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
