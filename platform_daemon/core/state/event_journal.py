"""The journal of events: what the processes of a daemon publish, numbered, for listeners that come and go.

Several processes append to one SQLite file, which gives all events one order of numbers.  The journal is a convenience
and no record: a thread that publishes an event never waits for the disk, and a journal that is damaged is set aside and
a new one is begun, with higher numbers.
"""

from __future__ import annotations

import sqlite3
import threading
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import structlog

from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.events import AnyEvent, Event

from .database import Database, Schema, WhenDamaged
from .errors import StorageError

log = structlog.get_logger()
MOST_KEPT = 100_000
"""Events that are kept; a listener that requests older ones receives the number of missing ones."""
MOST_WAITING = 10_000
"""Events that wait for the disk; while it refuses, the oldest of them are dropped."""
_STEP_S, _CLOSE_S = 0.05, 5.0
_TRIM_EVERY = 1000  # events


@dataclass(frozen=True)
class KeptEvent:
    """An event of the journal.  text: the whole event as JSON."""

    id: int
    kind: str
    text: str


def _create(sql: sqlite3.Connection) -> None:
    sql.execute(
        "CREATE TABLE events (id INTEGER PRIMARY KEY AUTOINCREMENT, at TEXT NOT NULL, kind TEXT NOT NULL, what TEXT)"
    )
    # The clock begins the numbers, so that they are higher than those of an earlier journal, however that was lost.
    base = (time.time_ns() // 1_000_000,)
    sql.execute("INSERT INTO sqlite_sequence (name, seq) VALUES ('events', ?)", base)
    sql.execute("CREATE TABLE base (number INTEGER NOT NULL)")
    sql.execute("INSERT INTO base VALUES (?)", base)


_SCHEMA = Schema(
    title="the journal of events",
    application_id=0x4D4D5245,  # "MMRE"
    version=1,
    create=_create,
    when_damaged=WhenDamaged.SET_ASIDE,
    remedy="free or repair the disk",
)


class EventJournal:
    """Appends events to the file at `path`, from a thread of its own, so that `tell` never waits for the disk."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._waiting: deque[tuple[str, AnyEvent]] = deque(maxlen=MOST_WAITING)
        self._wake = threading.Event()
        self._ended = threading.Event()
        self._batch: list[tuple[str, AnyEvent]] = []  # taken from `_waiting`, and not on the disk yet
        self._refused = False
        self._written = 0  # since the journal was trimmed
        self._thread = threading.Thread(target=self._work, name="events", daemon=True)
        self._thread.start()

    def tell(self, what: AnyEvent) -> None:
        """Publish an event, dated now, from any thread.  Never waits and never raises."""
        self._waiting.append((datetime.now(UTC).isoformat(timespec="milliseconds"), what))
        self._wake.set()

    def close(self) -> None:
        """Write the events that wait, and end.  Idempotent."""
        self._ended.set()
        self._wake.set()
        self._thread.join(_CLOSE_S)

    def _work(self) -> None:
        file: Database | None = None
        while True:
            ended = self._ended.is_set()
            self._wake.wait(1.0)
            self._wake.clear()
            try:
                file = file or Database(self._path, _SCHEMA)
                self._write(file)
                self._refused = False
            except StorageError as error:
                if not self._refused:  # logged once, not at each attempt
                    log.error("events_not_written", file=str(self._path), error=str(error))
                self._refused = True
                if file is not None:
                    file.close()
                file = None
            if ended:
                break
            self._ended.wait(_STEP_S)  # so that many events make one transaction
        if file is not None:
            file.close()

    def _write(self, file: Database) -> None:
        while self._waiting and len(self._batch) < MOST_WAITING:
            self._batch.append(self._waiting.popleft())
        if not self._batch:
            return
        rows = [(at, what.kind, to_json(what)) for at, what in self._batch]
        trim = self._written + len(rows) >= _TRIM_EVERY
        with file.transaction() as sql:
            sql.executemany("INSERT INTO events (at, kind, what) VALUES (?, ?, ?)", rows)
            if trim:
                sql.execute("DELETE FROM events WHERE id <= (SELECT max(id) FROM events) - ?", (MOST_KEPT,))
        self._written = 0 if trim else self._written + len(rows)
        self._batch.clear()


class EventReader:
    """Reads the journal that others write.  Every method raises StorageError where the file cannot be read."""

    def __init__(self, path: Path) -> None:
        self._file = Database(path, _SCHEMA)

    @property
    def base(self) -> int:
        """A number below those of all events of this journal."""
        return self._number("SELECT number FROM base")

    def newest(self) -> int:
        """Number of the newest event, or `base`."""
        return self._number("SELECT coalesce(max(id), (SELECT number FROM base)) FROM events")

    def forgotten(self) -> int:
        """The highest number whose event has been deleted, or `base`."""
        return self._number("SELECT coalesce(min(id) - 1, (SELECT number FROM base)) FROM events")

    def after(self, number: int, limit: int) -> Sequence[KeptEvent]:
        """The first `limit` events with numbers above `number`, in their order."""
        query = "SELECT id, at, kind, what FROM events WHERE id > ? ORDER BY id LIMIT ?"
        return [_kept(*row) for row in self._file.rows(query, (number, limit))]

    def close(self) -> None:
        """Idempotent."""
        self._file.close()

    def _number(self, query: str) -> int:
        return int(self._file.rows(query)[0][0])


def read_event(kept: KeptEvent) -> Event:
    """Parse an event.  Raises ValueError for one of another version of the daemon."""
    return Event.model_validate_json(kept.text)


def _kept(number: int, at: str, kind: str, what: str) -> KeptEvent:
    return KeptEvent(number, kind, f'{{"id":{number},"at":"{at}","what":{what}}}')
