"""Schedules and rows of the ledger, as a client sees them."""

from __future__ import annotations

from datetime import UTC, datetime

from .ledger import Row, UnreadableSchedule
from .schema import LedgerRow, Schedule


def unreadable(schedule: UnreadableSchedule) -> Schedule:
    """A schedule that another version has written, as a client sees it."""
    remedy = "remove it and add it again, or go back to the version that made it"
    return Schedule(
        id=schedule.id,
        request=None,
        created=iso(schedule.created),
        active=False,
        reason=f"this version cannot read it: {schedule.why}. Remedy: {remedy}",
        failures=0,
        next_due=None,
        ahead_until=None,
    )


def shown_row(row: Row) -> LedgerRow:
    """A row as a client sees it, with times in ISO 8601."""
    return LedgerRow.model_validate(
        {
            "number": row.number,
            "due": iso(row.due),
            "deadline": iso(row.deadline),
            "state": row.state,
            "reason": row.reason,
            "started": iso_or_none(row.started),
            "ended": iso_or_none(row.ended),
            "late_s": row.late_s,
            "job": row.job,
            "recording": row.recording,
        }
    )


def iso(moment: float) -> str:
    """A time in s since 1970, in ISO 8601."""
    return datetime.fromtimestamp(moment, UTC).isoformat()


def iso_or_none(moment: float | None) -> str | None:
    """The same, or None."""
    return None if moment is None else iso(moment)
