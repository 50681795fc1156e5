"""What the schedules of the hardware process offer to other processes."""

from __future__ import annotations

from typing import Protocol

from platform_daemon.core.service.platform_service import command, query

from .schema import LedgerPage, LedgerRow, Schedule, ScheduleRequest


class ScheduleService(Protocol):
    """Every method may raise HardwareAway, and StorageError while the ledger cannot be used."""

    @command
    def add(self, request: ScheduleRequest) -> Schedule:
        """Keep a schedule.  Raises InputError: never due, shorter than its work, work not possible."""

    @query
    def list(self) -> tuple[Schedule, ...]:
        """All that were not removed, oldest first."""

    @query
    def get(self, identifier: str) -> Schedule:
        """One of them.  Raises UnknownSchedule."""

    @query
    def page(self, identifier: str, after: int, limit: int) -> LedgerPage:
        """Rows of its ledger with numbers above `after`.  Raises UnknownSchedule."""

    @command
    def pause(self, identifier: str) -> Schedule:
        """Start nothing more.  Raises UnknownSchedule."""

    @command
    def resume(self, identifier: str) -> Schedule:
        """Start again what is due from now on.  Raises UnknownSchedule."""

    @command
    def run(self, identifier: str) -> LedgerRow:
        """Start it once, now.  Raises UnknownSchedule, DeviceStateError."""

    @command
    def remove(self, identifier: str) -> Schedule:
        """It starts nothing any more.  Raises UnknownSchedule."""

    def preview(self, request: ScheduleRequest, count: int) -> tuple[str, ...]:
        """The first instants.  Raises InputError."""
