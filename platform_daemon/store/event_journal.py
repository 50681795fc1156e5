"""The journal of events: what the processes of a daemon tell, numbered, for listeners that come and go.

SQLite, so that several processes write one order of numbers.  It is a convenience and no record: whoever tells never
waits for the disk, and a journal that is broken is put aside and begun anew, with higher numbers.
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
import threading
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import structlog

from platform_daemon.schemas import AnyHappening, Event, to_json

from .errors import StorageError

log = structlog.get_logger()
MOST_KEPT = 100_000
"""Events; older ones are forgotten, and whoever asks for them is told how many."""
MOST_WAITING = 10_000  # that the disk has not taken yet
_APPLICATION, _VERSION = 0x4D4D5245, 1  # "MMRE"
_STEP_S, _BUSY_S, _FORGET_EVERY = 0.05, 5.0, 1000
_BASE = "CREATE TABLE base (number INTEGER NOT NULL)"
_TABLE = "CREATE TABLE events (id INTEGER PRIMARY KEY AUTOINCREMENT, at TEXT NOT NULL, kind TEXT NOT NULL, what TEXT)"


@dataclass(frozen=True)
class KeptEvent:
    """An event as kept.  text: JSON of the whole event."""

    id: int
    kind: str
    text: str


class EventJournal:
    """Tells by `tell`, from any thread and at once; a thread of its own writes.  path: of the file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._waiting: deque[tuple[str, AnyHappening]] = deque(maxlen=MOST_WAITING)
        self._wake, self._ended = threading.Event(), threading.Event()
        self._batch: list[tuple[str, AnyHappening]] = []  # taken, and not on the disk yet
        self._refused, self._written = False, 0
        self._thread = threading.Thread(target=self._work, name="events", daemon=True)
        self._thread.start()

    def tell(self, what: AnyHappening) -> None:
        """It has happened now.  Never waits, never raises; while the disk refuses the oldest are lost."""
        self._waiting.append((datetime.now(UTC).isoformat(timespec="milliseconds"), what))
        self._wake.set()

    def close(self) -> None:
        """What was told is written.  Idempotent."""
        self._ended.set()
        self._wake.set()
        self._thread.join(_BUSY_S)

    def _work(self) -> None:
        sql: sqlite3.Connection | None = None
        while True:
            ended = self._ended.is_set()
            self._wake.wait(1.0)
            self._wake.clear()
            try:
                sql = sql or _opened(self._path)
                self._write(sql)
                self._refused = False
            except (sqlite3.Error, OSError) as error:
                if not self._refused:
                    log.error("events_not_written", file=str(self._path), error=str(error))
                self._refused = True
                if sql is not None:
                    sql.close()
                sql = None
            if ended:
                break
            self._ended.wait(_STEP_S)  # so that many events make one transaction
        if sql is not None:
            sql.close()

    def _write(self, sql: sqlite3.Connection) -> None:
        while self._waiting and len(self._batch) < MOST_WAITING:
            self._batch.append(self._waiting.popleft())
        if not self._batch:
            return
        rows = [(at, what.kind, to_json(what)) for at, what in self._batch]
        sql.execute("BEGIN IMMEDIATE")
        try:
            sql.executemany("INSERT INTO events (at, kind, what) VALUES (?, ?, ?)", rows)
            self._written += len(rows)
            if self._written >= _FORGET_EVERY:
                sql.execute("DELETE FROM events WHERE id <= (SELECT max(id) FROM events) - ?", (MOST_KEPT,))
                self._written = 0
            sql.execute("COMMIT")
        except BaseException:
            if sql.in_transaction:  # a full disk has rolled it back
                sql.execute("ROLLBACK")
            raise
        self._batch.clear()


class EventReader:
    """Reads the journal that others write.  Not for several threads at once.  Raises StorageError."""

    def __init__(self, path: Path) -> None:
        try:
            self._sql = _opened(path)
        except (sqlite3.Error, OSError) as error:
            remedy = "free or repair the disk"
            raise StorageError("the events cannot be read", where=str(path), why=str(error), remedy=remedy) from None

    @property
    def base(self) -> int:
        """All numbers of this journal are larger."""
        return int(self._sql.execute("SELECT number FROM base").fetchone()[0])

    def newest(self) -> int:
        """Number of the newest event, or `base`."""
        return int(self._sql.execute("SELECT coalesce(max(id), (SELECT number FROM base)) FROM events").fetchone()[0])

    def forgotten(self) -> int:
        """All numbers up to this one are kept no more."""
        return int(
            self._sql.execute("SELECT coalesce(min(id) - 1, (SELECT number FROM base)) FROM events").fetchone()[0]
        )

    def after(self, number: int, limit: int) -> Sequence[KeptEvent]:
        """The first events with larger numbers."""
        query = "SELECT id, at, kind, what FROM events WHERE id > ? ORDER BY id LIMIT ?"
        return [_kept(*row) for row in self._sql.execute(query, (number, limit))]

    def close(self) -> None:
        """Idempotent."""
        self._sql.close()


def read_event(kept: KeptEvent) -> Event:
    """It, typed."""
    return Event.model_validate_json(kept.text)


def _kept(number: int, at: str, kind: str, what: str) -> KeptEvent:
    return KeptEvent(number, kind, f'{{"id":{number},"at":"{at}","what":{what}}}')


def _opened(path: Path) -> sqlite3.Connection:
    """Raises sqlite3.Error, OSError."""
    try:
        return _connected(path)
    except sqlite3.DatabaseError as error:
        if isinstance(error, sqlite3.OperationalError):  # the disk or a lock, not the file
            raise
        aside = path.with_name(f"{path.name}.broken-{time.time_ns()}")
        log.error("events_put_aside", file=str(path), aside=aside.name, error=str(error))
        with contextlib.suppress(FileNotFoundError):  # another process was first
            os.replace(path, aside)
        for end in ("-wal", "-shm"):
            path.with_name(path.name + end).unlink(missing_ok=True)
        return _connected(path)


def _connected(path: Path) -> sqlite3.Connection:
    sql = sqlite3.connect(path, isolation_level=None, check_same_thread=False, timeout=_BUSY_S)
    try:
        sql.execute("PRAGMA journal_mode = WAL")
        sql.execute("PRAGMA synchronous = NORMAL")
        sql.execute("BEGIN IMMEDIATE")
        if sql.execute("PRAGMA user_version").fetchone()[0] == 0:
            sql.execute(_TABLE)
            # numbers that an earlier journal has not given out, in whatever way it was lost
            base = (time.time_ns() // 1_000_000,)
            sql.execute("INSERT INTO sqlite_sequence (name, seq) VALUES ('events', ?)", base)
            sql.execute(_BASE)
            sql.execute("INSERT INTO base VALUES (?)", base)
            sql.execute(f"PRAGMA application_id = {_APPLICATION}")
            sql.execute(f"PRAGMA user_version = {_VERSION}")
        sql.execute("COMMIT")
        found = [sql.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version")]
        if found != [_APPLICATION, _VERSION]:
            raise sqlite3.DatabaseError(f"it is no journal of version {_VERSION}")
    except BaseException:
        sql.close()
        raise
    return sql
