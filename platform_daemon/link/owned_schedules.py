"""The schedules of the owner of the hardware, as others ask for them."""

from __future__ import annotations

from platform_daemon.schedules import ScheduleKeeper, Schedules
from platform_daemon.schemas import LedgerPage, LedgerRow, Schedule, ScheduleRequest
from platform_daemon.store import StorageError


class OwnedSchedules:
    """schedules: None: there are none."""

    def __init__(self, schedules: ScheduleKeeper | None) -> None:
        self._schedules = schedules

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
        """Raises StorageError while their ledger cannot be used."""
        if self._schedules is None:
            raise StorageError("there are no schedules here", remedy="ask a daemon (`platform-daemon serve`)")
        return self._schedules.get()
