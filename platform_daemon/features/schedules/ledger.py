"""The ledger: schedules, and one row for each instant at which one of them was due.

Schedule and instant are the key of a row, so no instant is started twice, whatever clocks and restarts do.  Every
change is one transaction, on the disk when the method returns.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import structlog

from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.state.database import Database, Schema, WhenDamaged, tables

from .schema import ScheduleRequest

log = structlog.get_logger()
_SCHEMA = Schema(
    title="the ledger of the schedules",
    application_id=0x4D4D524C,  # "MMRL"
    version=1,
    create=tables("""
CREATE TABLE schedules (id TEXT PRIMARY KEY, request TEXT NOT NULL, created REAL NOT NULL, reached REAL NOT NULL,
    off TEXT, failures INTEGER NOT NULL DEFAULT 0, removed INTEGER NOT NULL DEFAULT 0) STRICT;
CREATE TABLE rows (number INTEGER PRIMARY KEY AUTOINCREMENT, schedule TEXT NOT NULL REFERENCES schedules(id),
    due REAL NOT NULL, begins REAL NOT NULL, deadline REAL NOT NULL, state TEXT NOT NULL, reason TEXT, started REAL,
    ended REAL, late_s REAL, job TEXT, recording TEXT, asked INTEGER NOT NULL DEFAULT 0, UNIQUE (schedule, due)) STRICT;
CREATE INDEX open_rows ON rows (schedule, due) WHERE state IN ('due', 'started')
"""),
    when_damaged=WhenDamaged.REFUSE,
    check_content=True,
    remedy="free or repair the disk; nothing was started, it is tried again",
)
STARTED_BY_HAND = "requested"
"""The reason of a row of a start by hand."""


@dataclass(frozen=True, kw_only=True)
class ScheduleRecord:
    """A schedule as the ledger keeps it.

    Attributes:
        id: of the schedule.
        request: what the client sent.
        created: when, in s since 1970.
        reached: all instants up to this one have a row, in s since 1970.
        off: why it starts nothing; None: it is active.
        failures: how many of its starts have failed in a row.
        removed: whether it was removed; its rows stay.
    """

    id: str
    request: ScheduleRequest
    created: float
    reached: float
    off: str | None = None
    failures: int = 0
    removed: bool = False


@dataclass(frozen=True, kw_only=True)
class UnreadableSchedule:
    """A schedule that another version has written.  created: s since 1970; why: it cannot be read."""

    id: str
    created: float
    removed: bool
    why: str


@dataclass(frozen=True, kw_only=True)
class Row:
    """One due instant; times in s since 1970.  begins: due plus jitter; by_hand: 1 for a start that a person requested
    for."""

    number: int
    schedule: str
    due: float
    begins: float
    deadline: float
    state: str
    reason: str | None
    started: float | None
    ended: float | None
    late_s: float | None
    job: str | None
    recording: str | None
    by_hand: int


_FIELDS = tuple(each.name for each in fields(Row))
_ROW = ", ".join(_FIELDS).replace("by_hand", "asked")  # the name of its column


def _row(values: tuple[Any, ...]) -> Row:
    return Row(**dict(zip(_FIELDS, values, strict=True)))


class Ledger:
    """The ledger in the file at `path`, which is made if it does not exist.

    Schedules and open rows are kept in memory and read again when this ledger or another process has changed the file.
    Every method raises StorageError where the disk refuses, and then nothing was changed; opening a damaged file raises
    DamagedDatabase.  Not for several threads at once.
    """

    def __init__(self, path: Path) -> None:
        self._file = Database(path, _SCHEMA)
        self._unreadable: dict[str, str] = {}  # why, by schedule
        self._schedules: list[ScheduleRecord | UnreadableSchedule] | None = None
        self._open_rows: list[Row] | None = None
        self._version = self._file.changed_by_others

    def close(self) -> None:
        """Idempotent."""
        self._file.close()

    def add(self, record: ScheduleRecord) -> None:
        """Keep a new schedule."""
        values = record.id, to_json(record.request), record.created, record.reached
        with self._change() as sql:
            sql.execute("INSERT INTO schedules (id, request, created, reached) VALUES (?, ?, ?, ?)", values)

    def schedules(self, *, removed: bool = False) -> list[ScheduleRecord]:
        """Schedules that this version can read, oldest first; removed: those that were removed, too."""
        found = [each for each in self._all() if isinstance(each, ScheduleRecord)]
        return [each for each in found if removed or not each.removed]

    def unreadable(self, *, removed: bool = False) -> list[UnreadableSchedule]:
        """The other schedules."""
        found = [each for each in self._all() if isinstance(each, UnreadableSchedule)]
        return [each for each in found if removed or not each.removed]

    def remove(self, schedule: str) -> None:
        """End a schedule for good; its rows stay, and those that are due are skipped."""
        with self._change() as sql:
            sql.execute("UPDATE schedules SET removed = 1, off = 'removed' WHERE id = ?", (schedule,))
            skip = "UPDATE rows SET state = 'skipped', reason = 'removed' WHERE schedule = ? AND state = 'due'"
            sql.execute(skip, (schedule,))

    def switch(self, schedule: str, off: str | None) -> None:
        """Switch a schedule off for the reason `off`, or on (None); its count of failures begins again at 0."""
        with self._change() as sql:
            sql.execute("UPDATE schedules SET off = ?, failures = 0 WHERE id = ?", (off, schedule))

    def suspend(self, reason: str) -> list[Row]:
        """Switch all schedules off, and skip starts by hand that have no job yet; returns the rows of the latter."""
        with self._change() as sql:
            query = f"SELECT {_ROW} FROM rows WHERE state = 'due' AND asked = 1"
            rows = [_row(found) for found in sql.execute(query)]
            skip = "UPDATE rows SET state = 'skipped', reason = ? WHERE state = 'due' AND asked = 1"
            sql.execute(skip, (reason,))
            sql.execute("UPDATE rows SET asked = 0 WHERE state = 'started'")  # those whose job is not made yet
            sql.execute("UPDATE schedules SET off = ?, failures = 0 WHERE off IS NULL", (reason,))
        return rows

    def reach(self, schedule: str, dues: list[tuple[float, float, float]], moment: float) -> None:
        """Add rows for instants (due, begins, deadline), and note that all up to `moment` have one."""
        rows = [(schedule, *due) for due in dues]
        with self._change() as sql:
            insert = "INSERT OR IGNORE INTO rows (schedule, due, begins, deadline, state) VALUES (?, ?, ?, ?, 'due')"
            sql.executemany(insert, rows)
            sql.execute("UPDATE schedules SET reached = max(reached, ?) WHERE id = ?", (moment, schedule))

    def pass_over(self, schedule: str, first: float, last: float, state: str, reason: str) -> list[Row]:
        """Add one row at the instant `first`, ended as `state`, for all instants up to `last`; returns it."""
        with self._change() as sql:
            insert = (
                "INSERT OR IGNORE INTO rows (schedule, due, begins, deadline, state, reason) VALUES (?, ?, ?, ?, ?, ?)"
            )
            sql.execute(insert, (schedule, first, first, last, state, reason))
            sql.execute("UPDATE schedules SET reached = max(reached, ?) WHERE id = ?", (last, schedule))
        query = f"SELECT {_ROW} FROM rows WHERE schedule = ? AND due = ?"
        return [_row(found) for found in self._file.rows(query, (schedule, first))]

    def go_back(self, schedule: str, moment: float) -> int:
        """Delete rows of instants after `moment` that have not begun, as they are still to come; returns how many."""
        with self._change() as sql:
            never = (
                "DELETE FROM rows WHERE schedule = ? AND due > ? AND job IS NULL AND asked = 0 AND state != 'failed'"
            )
            count = sql.execute(never, (schedule, moment)).rowcount
            earlier = "reached = min(reached, ?), created = min(created, ?)"
            sql.execute(f"UPDATE schedules SET {earlier} WHERE id = ?", (moment, moment, schedule))
        return count

    def add_by_hand(self, schedule: str, now: float, deadline: float) -> int:
        """Add a row for a start by hand, now; returns its number, or that of the row which that instant has already."""
        with self._change() as sql:
            insert = (
                "INSERT OR IGNORE INTO rows (schedule, due, begins, deadline, state, reason, asked)"
                " VALUES (?, ?, ?, ?, 'due', ?, 1)"
            )
            sql.execute(insert, (schedule, now, now, deadline, STARTED_BY_HAND))
        found = self._file.rows("SELECT number FROM rows WHERE schedule = ? AND due = ?", (schedule, now))
        return int(found[0][0])

    def open_rows(self) -> list[Row]:
        """Rows that are not final, by instant."""
        self._forget_if_changed()
        if self._open_rows is None:
            query = f"SELECT {_ROW} FROM rows WHERE state IN ('due', 'started') ORDER BY due, number"
            self._open_rows = [_row(found) for found in self._file.rows(query)]
        return list(self._open_rows)

    def rows(self, schedule: str, after: int = 0, limit: int = 100) -> list[Row]:
        """Rows of a schedule, which may have been removed, with numbers above `after`."""
        query = f"SELECT {_ROW} FROM rows WHERE schedule = ? AND number > ? ORDER BY number LIMIT ?"
        return [_row(found) for found in self._file.rows(query, (schedule, after, limit))]

    def close_rows(self, ends: list[tuple[int, str, str]]) -> None:
        """End rows (number, state, reason) that were never started."""
        with self._change() as sql:
            update = "UPDATE rows SET state = ?, reason = ? WHERE number = ? AND state = 'due'"
            sql.executemany(update, [(state, reason, number) for number, state, reason in ends])

    def note(self, row: Row, reason: str | None) -> None:
        """Keep what a row that is due waits for."""
        with self._change() as sql:
            sql.execute("UPDATE rows SET reason = ? WHERE number = ? AND state = 'due'", (reason, row.number))

    def starts_before(self, row: Row) -> int:
        """How many other starts of its schedule had a job, or should have had one.

        Rows that were due later count too: jitter, or a person, may have let them begin first.
        """
        count = "SELECT count(*) FROM rows WHERE schedule = ? AND number != ? AND (job IS NOT NULL OR state = 'failed')"
        return int(self._file.rows(count, (row.schedule, row.number))[0][0])

    def claim(self, row: Row, now: float, job: str) -> bool:
        """Note that a row becomes that job, before the job is made; False: the row was claimed already."""
        late = max(0.0, now - row.begins)
        with self._change() as sql:
            values = "state = 'started', started = ?, late_s = ?, job = ?"
            update = f"UPDATE rows SET {values} WHERE number = ? AND state = 'due'"
            return sql.execute(update, (now, late, job, row.number)).rowcount == 1

    def end(
        self, row: Row, state: str, now: float, *, reason: str | None, recording: str | None, off: str | None
    ) -> None:
        """End a row that was started, and count its failure; off: why its schedule is switched off, None: it is not."""
        with self._change() as sql:
            update = "UPDATE rows SET state = ?, ended = ?, reason = ?, recording = ?, job = ? WHERE number = ?"
            sql.execute(update, (state, now, reason, recording, row.job, row.number))
            count = "failures + 1" if state == "failed" else "0"
            sql.execute(
                f"UPDATE schedules SET failures = {count}, off = coalesce(?, off) WHERE id = ?", (off, row.schedule)
            )

    @contextmanager
    def _change(self) -> Iterator[sqlite3.Connection]:
        self._schedules = self._open_rows = None
        with self._file.transaction() as sql:
            yield sql

    def _forget_if_changed(self) -> None:
        """Drop what is kept in memory where another connection has changed the file."""
        version = self._file.changed_by_others
        if version != self._version:
            self._version = version
            self._schedules = self._open_rows = None

    def _all(self) -> list[ScheduleRecord | UnreadableSchedule]:
        self._forget_if_changed()
        if self._schedules is None:
            query = "SELECT id, request, created, reached, off, failures, removed FROM schedules ORDER BY rowid"
            self._schedules = [self._record(row) for row in self._file.rows(query)]
        return self._schedules

    def _record(self, values: tuple[Any, ...]) -> ScheduleRecord | UnreadableSchedule:
        identifier, text, created, reached, off, failures, removed = values
        try:
            request = ScheduleRequest.model_validate_json(text)
        except ValueError as error:
            if identifier not in self._unreadable:  # logged once
                log.error("schedule_not_read", schedule=identifier, error=str(error))
                self._unreadable[identifier] = str(error)
            return UnreadableSchedule(id=identifier, created=created, removed=bool(removed), why=str(error))
        return ScheduleRecord(
            id=identifier,
            request=request,
            created=created,
            reached=reached,
            off=off,
            failures=failures,
            removed=bool(removed),
        )
