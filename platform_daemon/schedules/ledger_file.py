"""The file of the ledger, in SQLite.

Every change is one transaction that is on the disk when the call returns (WAL, synchronous FULL): after a power loss
all of it is there or nothing.  A file that is no whole ledger is refused by name, and never replaced by an empty one.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

import structlog

from platform_daemon.store import StorageError, sync

log = structlog.get_logger()
_APPLICATION, _VERSION = 0x4D4D524C, 1  # "MMRL"
_TABLES = """
CREATE TABLE schedules (id TEXT PRIMARY KEY, request TEXT NOT NULL, created REAL NOT NULL, reached REAL NOT NULL,
    off TEXT, failures INTEGER NOT NULL DEFAULT 0, removed INTEGER NOT NULL DEFAULT 0) STRICT;
CREATE TABLE rows (number INTEGER PRIMARY KEY AUTOINCREMENT, schedule TEXT NOT NULL REFERENCES schedules(id),
    due REAL NOT NULL, begins REAL NOT NULL, deadline REAL NOT NULL, state TEXT NOT NULL, reason TEXT, started REAL,
    ended REAL, late_s REAL, job TEXT, recording TEXT, asked INTEGER NOT NULL DEFAULT 0, UNIQUE (schedule, due)) STRICT;
CREATE INDEX open_rows ON rows (schedule, due) WHERE state IN ('due', 'started');
"""


class DamagedLedger(StorageError):
    """It is there and is no whole ledger."""


class LedgerFile:
    """The file, open.  Not for several threads at once.

    Raises DamagedLedger; StorageError: the disk refuses, or the file was taken away while it is open, so that nothing
    would be kept.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            if not path.exists():
                if any(each.exists() for each in _beside(path)):
                    raise self._damaged("the file is gone, its log is there")
                _begin(path)
            self._file = _file(path)
            self._check_length()
            self._sql = _connected(path)
        except (OSError, sqlite3.Error) as error:
            raise self._refused(error) from error
        try:
            self._open()
        except sqlite3.DatabaseError as error:
            self._sql.close()
            if isinstance(error, sqlite3.OperationalError):
                raise self._refused(error) from error
            raise self._damaged(str(error)) from error
        except StorageError:
            self._sql.close()
            raise

    def close(self) -> None:
        """Idempotent."""
        self._sql.close()

    def _open(self) -> None:
        self._sql.execute("PRAGMA journal_mode = WAL")
        self._sql.execute("PRAGMA synchronous = FULL")
        found = self._sql.execute("PRAGMA quick_check(1)").fetchone()[0]
        if found != "ok":
            raise self._damaged(str(found))
        ours = self._sql.execute("PRAGMA application_id").fetchone()[0]
        version = self._sql.execute("PRAGMA user_version").fetchone()[0]
        if (ours, version) != (_APPLICATION, _VERSION):
            raise self._damaged(f"it is no ledger of version {_VERSION}")

    def _check_length(self) -> None:
        """Raises StorageError for a file shorter than it says: SQLite takes an empty one for a new one."""
        size = self._path.stat().st_size
        with self._path.open("rb") as file:
            head = file.read(100)
        wal = self._path.with_name(self._path.name + "-wal")
        if wal.exists() and wal.stat().st_size:
            if size:
                return  # SQLite puts both together, and is asked whether the whole is sound
            raise self._damaged("it is empty")
        page = int.from_bytes(head[16:18]) if len(head) == 100 else 0
        page = 65536 if page == 1 else page
        if page == 0 or size < page * int.from_bytes(head[28:32]):
            raise self._damaged(f"it has been cut off after {size} bytes")

    def _read(self, query: str, values: tuple[object, ...] = ()) -> list[tuple[Any, ...]]:
        self._check_there()
        try:
            return self._sql.execute(query, values).fetchall()
        except sqlite3.Error as error:
            raise self._refused(error) from error

    @contextmanager
    def _change(self) -> Iterator[None]:
        """One transaction.  Raises StorageError: nothing of it was done."""
        self._check_there()
        try:
            self._sql.execute("BEGIN IMMEDIATE")
            yield
            self._sql.execute("COMMIT")
        except sqlite3.Error as error:
            if self._sql.in_transaction:
                self._sql.execute("ROLLBACK")
            raise self._refused(error) from error

    def _check_there(self) -> None:
        """Raises StorageError where another file, or none, has its name: what is written here nobody would find."""
        with suppress(OSError):
            if _file(self._path) == self._file:
                return
        raise StorageError(
            "the ledger of the schedules was taken away",
            where=str(self._path),
            why="its file has been moved, removed or replaced while it was in use",
            remedy="put it back, with what is beside it; or remove that too "
            f"({', '.join(each.name for each in _beside(self._path))}) and start the daemon again, to begin a new one",
        )

    def _refused(self, error: Exception) -> StorageError:
        remedy = "free or repair the disk; nothing was started, it is tried again"
        return StorageError(
            "the ledger cannot be read or written", where=str(self._path), why=str(error), remedy=remedy
        )

    def _damaged(self, why: str) -> DamagedLedger:
        remedy = (
            "put back a copy of it, or move it away to begin a new one, without what it says of earlier starts, and in "
            f"either case what is beside it ({', '.join(each.name for each in _beside(self._path))}); "
            "then start the daemon again"
        )
        return DamagedLedger("the ledger of the schedules is damaged", where=str(self._path), why=why, remedy=remedy)


def _beside(path: Path) -> list[Path]:
    """What SQLite may have left beside it, without which, or beside another file, its content is not whole."""
    return [path.with_name(path.name + end) for end in ("-wal", "-shm", "-journal")]


def _connected(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(path, isolation_level=None, check_same_thread=False)


def _begin(path: Path) -> None:
    """A new ledger, whole or not at all.  Raises OSError, sqlite3.Error."""
    part = path.with_name(f".{path.name}.part")
    for left in (part, part.with_name(f"{part.name}-journal")):  # of one that died here
        left.unlink(missing_ok=True)
    with closing(_connected(part)) as sql:
        tables = f"BEGIN IMMEDIATE; {_TABLES} PRAGMA application_id = {_APPLICATION};"
        sql.executescript(f"{tables} PRAGMA user_version = {_VERSION}; COMMIT;")
    sync(part)
    os.replace(part, path)
    sync(path.parent)
    log.info("ledger_begun", file=str(path))


def _file(path: Path) -> tuple[int, int]:
    """Which file has that name.  Raises OSError."""
    found = path.stat()
    return found.st_dev, found.st_ino
