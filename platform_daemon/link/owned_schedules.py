"""The schedules of the owner of the hardware, as others ask for them."""

from __future__ import annotations

from collections.abc import Callable

from platform_daemon.schedules import Schedules
from platform_daemon.schemas import LedgerPage, LedgerRow, Schedule, ScheduleRequest
from platform_daemon.store import StorageError


class OwnedSchedules:
    """schedules: tells those there are, None: their ledger is damaged; damage: says how."""

    def __init__(self, schedules: Callable[[], Schedules | None], damage: Callable[[], StorageError | None]) -> None:
        self._schedules, self._damage = schedules, damage

    def add_schedule(self, request: ScheduleRequest) -> Schedule:
        """See Hardware."""
        return self._known_schedules.add(request)

    def list_schedules(self) -> tuple[Schedule, ...]:
        """See Hardware."""
        return self._known_schedules.list()

    def get_schedule(self, identifier: str) -> Schedule:
        """See Hardware."""
        return self._known_schedules.get(identifier)

    def ledger(self, identifier: str, after: int, limit: int) -> LedgerPage:
        """See Hardware."""
        return self._known_schedules.page(identifier, after, limit)

    def pause_schedule(self, identifier: str) -> Schedule:
        """See Hardware."""
        return self._known_schedules.pause(identifier)

    def resume_schedule(self, identifier: str) -> Schedule:
        """See Hardware."""
        return self._known_schedules.resume(identifier)

    def run_schedule(self, identifier: str) -> LedgerRow:
        """See Hardware."""
        return self._known_schedules.run(identifier)

    def remove_schedule(self, identifier: str) -> Schedule:
        """See Hardware."""
        return self._known_schedules.remove(identifier)

    def preview_schedule(self, request: ScheduleRequest, count: int) -> tuple[str, ...]:
        """See Hardware."""
        return self._known_schedules.preview(request, count)

    @property
    def _known_schedules(self) -> Schedules:
        """Raises StorageError where the ledger is damaged."""
        found = self._schedules()
        if found is None:
            damage = self._damage()
            what, why = "there are no schedules: their ledger cannot be used", damage and damage.why
            remedy = "put back a copy of it, or move it away to begin a new one; then start the daemon again"
            raise StorageError(what, where=(damage and damage.where) or "schedules.db", why=why or "", remedy=remedy)
        return found
