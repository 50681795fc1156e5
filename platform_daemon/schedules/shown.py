"""Schedules and rows of the ledger, as others see them."""

from __future__ import annotations

from datetime import UTC, datetime

from platform_daemon.schemas import LedgerRow, Schedule

from .ledger import Row


def unreadable(identifier: str, created: float, why: str) -> Schedule:
    """One that another version has left; created: s since 1970; why: it cannot be read."""
    remedy = "remove it and add it anew, or go back to the version that made it"
    return Schedule(
        identifier=identifier,
        request=None,
        created=iso(created),
        active=False,
        reason=f"this version cannot read it: {why}. Remedy: {remedy}",
        failures=0,
        next_due=None,
        ahead_until=None,
    )


def shown_row(row: Row) -> LedgerRow:
    """A row, with times in ISO 8601."""
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
    """ISO 8601 of s since 1970."""
    return datetime.fromtimestamp(moment, UTC).isoformat()


def iso_or_none(moment: float | None) -> str | None:
    """The same; None: there is none."""
    return None if moment is None else iso(moment)
