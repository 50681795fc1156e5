"""Which resonator is in the clamping unit, where a person has to put it there."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import structlog

from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.unattended import MountedResonator
from platform_daemon.core.state.durable import write_file

log = structlog.get_logger()


class Mounted:
    """Which resonator is mounted, as last reported.

    path: file that keeps it over a restart; changes_itself: the platform mounts resonators by itself.
    """

    def __init__(self, path: Path, *, changes_itself: bool) -> None:
        self._path, self._itself = path, changes_itself

    def now(self) -> MountedResonator:
        """The last report."""
        try:
            kept = MountedResonator.model_validate_json(self._path.read_bytes())
        except FileNotFoundError:
            kept = MountedResonator(resonator=None, by=None, at=None, changed_by_platform=self._itself)
        except (OSError, ValueError) as error:  # it has to be reported again
            log.error("mounted_resonator_not_read", file=str(self._path), error=str(error))
            kept = MountedResonator(resonator=None, by=None, at=None, changed_by_platform=self._itself)
        return kept.model_copy(update={"changed_by_platform": self._itself})

    def say(self, resonator: str, by: str | None) -> MountedResonator:
        """Report a resonator as mounted.  by: the person, None: a request that measures it.  Raises StorageError."""
        known = self.now()
        if by is None and known.resonator == resonator:
            return known
        found = MountedResonator(
            resonator=resonator, by=by, at=datetime.now(UTC).isoformat(), changed_by_platform=self._itself
        )
        write_file(self._path, to_json(found, indent=1).encode())
        return found

    def missing(self, resonator: str, *, surely: bool) -> str | None:
        """What a person has to do before it can be measured; None: nothing.

        surely: also without any report of a mounted resonator; otherwise this one is then assumed.
        """
        now = self.now()
        if now.changed_by_platform or now.resonator == resonator or (now.resonator is None and not surely):
            return None
        there = "no mounted resonator has been reported" if now.resonator is None else f"{now.resonator} is there"
        return f"{resonator} has to be mounted, {there}: do it, then say so (POST /platform/resonator)"
