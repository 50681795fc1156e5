"""Could it be done here at all?  What a dry run and a request are told before anything moves."""

from __future__ import annotations

from pathlib import Path

from platform_daemon.engine import Engine
from platform_daemon.store import check_room


def check_feasible(engine: Engine, recordings: Path, disk_bytes: int, shots: int) -> None:
    """Raises StorageUnusable without room for so many bytes and shots; InterlockError where the platform is set so that
    no power may come, as with a lease that is too long."""
    check_room(recordings, disk_bytes, shots)
    unfit = engine.platform.guard.unfit()
    if unfit is not None:
        raise unfit
