"""The ledger: schedules and one row per due instant.  Schedule and instant are a key: none can stand in it twice."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import structlog

from platform_daemon.schemas import ScheduleRequest, to_json

from .ledger_file import LedgerFile

log = structlog.get_logger()
_ROW = "number, schedule, due, begins, deadline, state, reason, started, ended, late_s, job, recording, asked"
ASKED_FOR = "asked for"
"""The reason of a row of a start by hand."""


@dataclass(frozen=True)
class Kept:
    """A schedule as kept.  created, reached: s since 1970; off: why it starts nothing.

    reached: all instants up to it stand in the ledger.
    """

    identifier: str
    request: ScheduleRequest
    created: float
    reached: float
    off: str | None
    failures: int


@dataclass(frozen=True)
class Row:
    """One due instant; times in s since 1970.  begins: due plus jitter; asked: started by hand."""

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
    asked: int


class Ledger(LedgerFile):
    """What is kept in the file.  Not for several threads at once.  Raises DamagedLedger, StorageError."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._unreadable: dict[str, str] = {}

    def add(self, kept: Kept) -> None:
        """A new schedule."""
        values = kept.identifier, to_json(kept.request), kept.created, kept.reached
        with self._change():
            self._sql.execute("INSERT INTO schedules (id, request, created, reached) VALUES (?, ?, ?, ?)", values)

    def schedules(self, *, removed: bool = False) -> list[Kept]:
        """Those that were not removed (removed: all), oldest first; one of another version that cannot be read is left
        out, which is logged."""
        which = "" if removed else "WHERE removed = 0"
        query = f"SELECT id, request, created, reached, off, failures FROM schedules {which} ORDER BY rowid"
        found = ((row, self._request(row[0], row[1])) for row in self._read(query))
        return [Kept(row[0], request, *row[2:]) for row, request in found if request is not None]

    def unreadable(self, *, removed: bool = False) -> dict[str, tuple[float, str]]:
        """Those of another version that `schedules` leaves out, by id: since when, and what is wrong."""
        which = "" if removed else "WHERE removed = 0"
        query = f"SELECT id, request, created FROM schedules {which} ORDER BY rowid"
        found = [row for row in self._read(query) if self._request(row[0], row[1]) is None]
        return {row[0]: (row[2], self._unreadable[row[0]]) for row in found}

    def _request(self, schedule: str, text: str) -> ScheduleRequest | None:
        try:
            return ScheduleRequest.model_validate_json(text)
        except ValueError as error:
            if schedule not in self._unreadable:  # once
                log.error("schedule_not_read", schedule=schedule, error=str(error))
                self._unreadable[schedule] = str(error)
            return None

    def remove(self, schedule: str) -> None:
        """It starts nothing any more; its rows stay."""
        with self._change():
            self._sql.execute("UPDATE schedules SET removed = 1, off = 'removed' WHERE id = ?", (schedule,))
            self._skip(schedule, "removed")

    def switch(self, schedule: str, off: str | None) -> None:
        """Switch it off, for that reason, or on (None), which forgets its failures."""
        with self._change():
            self._sql.execute("UPDATE schedules SET off = ?, failures = 0 WHERE id = ?", (off, schedule))

    def rest(self, reason: str) -> list[Row]:
        """Switch all off, for that reason, also starts by hand that have no job yet; rows that were skipped by it."""
        with self._change():
            query = f"SELECT {_ROW} FROM rows WHERE state = 'due' AND asked = 1"
            rows = [Row(*found) for found in self._sql.execute(query)]
            skip = "UPDATE rows SET state = 'skipped', reason = ? WHERE state = 'due' AND asked = 1"
            self._sql.execute(skip, (reason,))
            self._sql.execute("UPDATE rows SET asked = 0 WHERE state = 'started'")  # whose job is not made yet
            self._sql.execute("UPDATE schedules SET off = ?, failures = 0 WHERE off IS NULL", (reason,))
        return rows

    def reach(self, schedule: str, dues: list[tuple[float, float, float]], moment: float) -> None:
        """Write down instants (due, begins, deadline), and that all up to `moment` are."""
        rows = [(schedule, *due) for due in dues]
        with self._change():
            insert = "INSERT OR IGNORE INTO rows (schedule, due, begins, deadline, state) VALUES (?, ?, ?, ?, 'due')"
            self._sql.executemany(insert, rows)
            self._sql.execute("UPDATE schedules SET reached = max(reached, ?) WHERE id = ?", (moment, schedule))

    def go_back(self, schedule: str, moment: float) -> int:
        """Forget the instants after `moment` that have not begun: they are still to come; how many they were."""
        with self._change():
            never = (
                "DELETE FROM rows WHERE schedule = ? AND due > ? AND job IS NULL AND asked = 0 AND state != 'failed'"
            )
            count = self._sql.execute(never, (schedule, moment)).rowcount
            earlier = "reached = min(reached, ?), created = min(created, ?)"
            self._sql.execute(f"UPDATE schedules SET {earlier} WHERE id = ?", (moment, moment, schedule))
        return count

    def ask(self, schedule: str, now: float, deadline: float) -> int:
        """A row for a start by hand, now; its number, of the row that is there already if there is one."""
        with self._change():
            insert = (
                "INSERT OR IGNORE INTO rows (schedule, due, begins, deadline, state, reason, asked)"
                " VALUES (?, ?, ?, ?, 'due', ?, 1)"
            )
            self._sql.execute(insert, (schedule, now, now, deadline, ASKED_FOR))
        found = self._read("SELECT number FROM rows WHERE schedule = ? AND due = ?", (schedule, now))
        return int(found[0][0])

    def open_rows(self) -> list[Row]:
        """Rows that are not final, by instant."""
        query = f"SELECT {_ROW} FROM rows WHERE state IN ('due', 'started') ORDER BY due, number"
        return [Row(*found) for found in self._read(query)]

    def rows(self, schedule: str, after: int = 0, limit: int = 100) -> list[Row]:
        """Rows of a schedule, removed ones too, with numbers above `after`."""
        query = f"SELECT {_ROW} FROM rows WHERE schedule = ? AND number > ? ORDER BY number LIMIT ?"
        return [Row(*found) for found in self._read(query, (schedule, after, limit))]

    def close_rows(self, ends: list[tuple[int, str, str]]) -> None:
        """Rows (number, state, reason) that were never started."""
        with self._change():
            update = "UPDATE rows SET state = ?, reason = ? WHERE number = ? AND state = 'due'"
            self._sql.executemany(update, [(state, reason, number) for number, state, reason in ends])

    def note(self, row: Row, reason: str | None) -> None:
        """What a row that is due waits for."""
        with self._change():
            self._sql.execute("UPDATE rows SET reason = ? WHERE number = ? AND state = 'due'", (reason, row.number))

    def turn(self, row: Row) -> int:
        """How many starts of its schedule had a job before it, or should have had one: those that were due later too,
        which jitter or a person may have let begin first."""
        count = "SELECT count(*) FROM rows WHERE schedule = ? AND number != ? AND (job IS NOT NULL OR state = 'failed')"
        return int(self._read(count, (row.schedule, row.number))[0][0])

    def claim(self, row: Row, now: float, job: str) -> bool:
        """It will become that job.  Durable before anything moves; False: it was claimed already."""
        late = max(0.0, now - row.begins)
        with self._change():
            values = "state = 'started', started = ?, late_s = ?, job = ?"
            update = f"UPDATE rows SET {values} WHERE number = ? AND state = 'due'"
            return self._sql.execute(update, (now, late, job, row.number)).rowcount == 1

    def end(self, row: Row, state: str, now: float, reason: str | None, recording: str | None, off: str | None) -> None:
        """A started row has ended, with the job that it has; with it the count of failures, and off: why its schedule
        is switched off."""
        with self._change():
            update = "UPDATE rows SET state = ?, ended = ?, reason = ?, recording = ?, job = ? WHERE number = ?"
            self._sql.execute(update, (state, now, reason, recording, row.job, row.number))
            count = "failures + 1" if state == "failed" else "0"
            self._sql.execute(
                f"UPDATE schedules SET failures = {count}, off = coalesce(?, off) WHERE id = ?", (off, row.schedule)
            )

    def _skip(self, schedule: str, reason: str) -> None:
        update = "UPDATE rows SET state = 'skipped', reason = ? WHERE schedule = ? AND state = 'due'"
        self._sql.execute(update, (reason, schedule))
