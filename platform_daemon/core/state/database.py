"""SQLite files: how each of them is begun, checked, read and changed, and what happens to one that is damaged.

A `Schema` says what a file holds and how precious that is.  Files of the policy REFUSE hold what was acknowledged: a
transaction is on the disk when it ends (synchronous FULL), the file is made whole or not at all, and one that is
damaged, cut off or was taken away is refused by its name and never replaced by an empty one.  All other
files hold what is convenient (SET_ASIDE) or can be made again (DELETE): a power loss may cost them their last
transactions (synchronous NORMAL), and one that is damaged is replaced by a new one.

Several processes may have one file open.  They take turns: a transaction begins by BEGIN IMMEDIATE, so it waits at its
begin (for at most BUSY_S) and never finds half-way that another process has written meanwhile.
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from pathlib import Path
from typing import Any, Literal

import structlog

from .durable import PART, part_of, publish_new, sweep
from .errors import StorageError

log = structlog.get_logger()
BUSY_S = 5.0
"""How long a connection waits for the transaction of another one, in s."""
_PRIMARY_CODE, _DAMAGE = 0xFF, (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
_HEADER_BYTES = 100  # of an SQLite file: https://www.sqlite.org/fileformat.html#the_database_header


class WhenDamaged(Enum):
    """What happens to a file that is damaged, of another version, or no such file at all."""

    REFUSE = auto()
    """It is refused by its name, and stays as it is."""
    SET_ASIDE = auto()
    """It is renamed, and a new one is begun."""
    DELETE = auto()
    """A new one takes its place, made from other files."""


@dataclass(frozen=True, kw_only=True)
class Schema:
    """What an SQLite file holds.

    Attributes:
        title: what errors and the log call the file, as in "the ledger of the schedules".
        application_id: of SQLite's header, which tells our files from those of other programs.
        version: of the tables; a file of another version counts as damaged.
        create: makes the tables in an empty file, within a transaction.  Raises sqlite3.Error.
        when_damaged: the policy.
        check_content: whether all pages are checked at each opening (REFUSE only), which takes as long as reading the
            file; the length is always checked.
        journal: WAL: readers never wait for a writer; TRUNCATE: a disk that is full can still be read, because reading
            needs no further file.
        remedy: what a person does when the disk refuses.
    """

    title: str
    application_id: int
    version: int
    create: Callable[[sqlite3.Connection], None]
    when_damaged: WhenDamaged
    check_content: bool = False
    journal: Literal["WAL", "TRUNCATE"] = "WAL"
    remedy: str = "free or repair the disk; what was not done is tried again"


class DamagedDatabase(StorageError):
    """An SQLite file is there, but it is not whole, or it is of another version."""

    title = "Damaged file"


class _NotOurs(sqlite3.DatabaseError):
    """The file is no database of this schema and version."""


@dataclass
class _Batch:
    """Statements of several threads that share a transaction."""

    statements: list[tuple[str, Sequence[object]]] = field(default_factory=list)
    ended: bool = False
    error: StorageError | None = None


class Database:
    """An SQLite file, open.  Any number of threads may use it: each call waits for the one before.

    Opening makes a file that does not exist.  Errors of all methods: StorageError, where the disk refuses, another
    process keeps the file busy, or (REFUSE) the file was taken away while it was open, so that nothing would be kept;
    DamagedDatabase for a file that is damaged (REFUSE).

    Example:
        >>> with Database(path, SCHEMA).transaction() as sql:
        ...     sql.execute("INSERT INTO jobs (id, state) VALUES (?, ?)", ("fit-1", "queued"))
    """

    def __init__(self, path: Path, schema: Schema) -> None:
        self.path, self.schema = path, schema
        self.damaged = False
        """Whether an operation has found the file damaged since it was opened."""
        self._lock = threading.RLock()
        self._batch_lock = threading.Lock()
        self._batch = _Batch()
        try:
            self._sql = self._opened()
        except (OSError, sqlite3.Error) as error:
            raise self._refusal(error) from error
        self._file = _identity(path) if self._precious else None

    def close(self) -> None:
        """Let the file go.  Idempotent."""
        with self._lock:
            self._sql.close()

    def rows(self, query: str, values: Sequence[object] = ()) -> list[Any]:
        """All rows of a query, as tuples."""
        with self._lock:
            self._check_in_place()
            try:
                return self._sql.execute(query, values).fetchall()
            except sqlite3.Error as error:
                raise self._refusal(error) from error

    @contextlib.contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Changes that are all made, on the disk at the end of the block (REFUSE), or not at all if it raises."""
        with self._lock:
            self._check_in_place()
            try:
                self._sql.execute("BEGIN IMMEDIATE")
                yield self._sql
                self._sql.execute("COMMIT")
            except BaseException as error:
                with contextlib.suppress(sqlite3.Error):  # it is closed, or has rolled back as the disk is full
                    if self._sql.in_transaction:
                        self._sql.execute("ROLLBACK")
                if isinstance(error, sqlite3.Error):
                    raise self._refusal(error) from error
                raise

    def execute(self, statement: str, values: Sequence[object] = ()) -> None:
        """Execute one statement, in one transaction with those of all threads that wait for the disk meanwhile.

        The disk syncs many changes as fast as one: the first thread writes for all others.
        """
        with self._batch_lock:
            batch = self._batch
            batch.statements.append((statement, values))
        with self._lock:
            if not batch.ended:
                with self._batch_lock:
                    self._batch = _Batch()
                try:
                    with self.transaction() as sql:
                        for each in batch.statements:
                            sql.execute(*each)
                except StorageError as error:
                    batch.error = error
                finally:
                    batch.ended = True
        if batch.error is not None:
            raise batch.error.with_traceback(None)

    @property
    def changed_by_others(self) -> int:
        """A number that changes when another connection has changed the file."""
        return int(self.rows("PRAGMA data_version")[0][0])

    def add_function(self, name: str, function: Callable[[str], str]) -> None:
        """Let queries call a deterministic function of one text by that name."""
        self._sql.create_function(name, 1, function, deterministic=True)

    @property
    def _precious(self) -> bool:
        return self.schema.when_damaged is WhenDamaged.REFUSE

    def _opened(self) -> sqlite3.Connection:
        """Raises StorageError, OSError, sqlite3.Error."""
        try:
            return self._connected()
        except sqlite3.DatabaseError as error:
            if isinstance(error, sqlite3.OperationalError):  # the disk or a lock, not the file
                raise
            if self._precious:
                raise self._damage(str(error)) from error
            self._replace(str(error))
            return self._connected()

    def _connected(self) -> sqlite3.Connection:
        """Raises DamagedDatabase, OSError, sqlite3.Error."""
        if not self.path.exists():
            log = any(_has_content(each) for each in companions(self.path))
            if self._precious and log and not self.path.exists():  # else somebody made both in between
                raise self._damage("the file is gone, its log is there")
            self._create()
        self._check_length()
        sql = sqlite3.connect(self.path, isolation_level=None, check_same_thread=False, timeout=BUSY_S)
        try:
            sql.execute(f"PRAGMA journal_mode = {self.schema.journal}")
            sql.execute(f"PRAGMA synchronous = {'FULL' if self._precious else 'NORMAL'}")
            if self._precious and self.schema.check_content:
                found = sql.execute("PRAGMA quick_check(1)").fetchone()[0]
                if found != "ok":
                    raise _NotOurs(str(found))
            ours = tuple(sql.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version"))
            if ours != (self.schema.application_id, self.schema.version):
                raise _NotOurs(f"it is no {_bare(self.schema.title)} of version {self.schema.version}")
        except BaseException:
            sql.close()
            raise
        return sql

    def _create(self) -> None:
        """A new file, whole or not at all, also if another process makes one now.  Raises OSError, sqlite3.Error."""
        sweep([self.path.parent], f".{self.path.name}.*{PART}")  # of processes that died here
        part = part_of(self.path)
        try:
            with contextlib.closing(sqlite3.connect(part, isolation_level=None)) as sql:
                sql.execute("PRAGMA journal_mode = MEMORY")  # a file that was never published needs no journal
                sql.execute("BEGIN")
                self.schema.create(sql)
                sql.execute(f"PRAGMA application_id = {self.schema.application_id}")
                sql.execute(f"PRAGMA user_version = {self.schema.version}")
                sql.execute("COMMIT")
            if publish_new(part, self.path):
                log.info("database_created", file=str(self.path))
        finally:
            with contextlib.suppress(OSError):
                part.unlink()

    def _check_length(self) -> None:
        """Raises _NotOurs for a file shorter than its header says: SQLite takes an empty file for a new one."""
        size = self.path.stat().st_size
        log_file = companions(self.path)[0]
        if log_file.exists() and log_file.stat().st_size:
            if size:
                return  # SQLite puts both together, and is asked whether the whole is sound
            raise _NotOurs("it is empty")
        with self.path.open("rb") as file:
            head = file.read(_HEADER_BYTES)
        page = int.from_bytes(head[16:18]) if len(head) == _HEADER_BYTES else 0
        page = 65536 if page == 1 else page
        if page == 0 or size < page * int.from_bytes(head[28:32]):
            raise _NotOurs(f"it has been cut off after {size} bytes")

    def _replace(self, why: str) -> None:
        """Make room for a new file.  Raises OSError."""
        if self.schema.when_damaged is WhenDamaged.SET_ASIDE:
            aside = self.path.with_name(f"{self.path.name}.broken-{time.time_ns()}")
            log.error("database_set_aside", file=str(self.path), aside=aside.name, error=why)
            with contextlib.suppress(FileNotFoundError):  # another process was first
                os.replace(self.path, aside)
        else:
            log.warning("database_made_again", file=str(self.path), error=why)
        delete(self.path)

    def _check_in_place(self) -> None:
        """Raises StorageError where another file, or none, has the name: rows written here would be lost."""
        if self._file is None:
            return
        with contextlib.suppress(OSError):
            if _identity(self.path) == self._file:
                return
        raise StorageError(
            f"{self.schema.title} was taken away",
            where=str(self.path),
            why="its file has been moved, removed or replaced while it was in use",
            remedy="put it back, together with its companions; or remove these too "
            f"({_names(self.path)}) and start the daemon again, to begin a new one",
        )

    def _refusal(self, error: Exception) -> StorageError:
        damaged = isinstance(error, sqlite3.DatabaseError) and not isinstance(error, sqlite3.OperationalError)
        self.damaged = self.damaged or damaged
        if self._precious and getattr(error, "sqlite_errorcode", 0) & _PRIMARY_CODE in _DAMAGE:
            return self._damage(str(error))  # a person has to put it back: to free the disk would not help
        return StorageError(
            f"{self.schema.title} cannot be read or written",
            where=str(self.path),
            why=str(error),
            remedy=self.schema.remedy,
        )

    def _damage(self, why: str) -> DamagedDatabase:
        return DamagedDatabase(
            f"{self.schema.title} is damaged",
            where=str(self.path),
            why=why,
            remedy="put back a copy of it, or move it away to begin a new one, without what it says; in either case "
            f"treat its companions ({_names(self.path)}) alike; then start the daemon again",
        )


def tables(script: str) -> Callable[[sqlite3.Connection], None]:
    """`Schema.create` of statements that are separated by semicolons."""

    def create(sql: sqlite3.Connection) -> None:
        for statement in script.split(";"):
            sql.execute(statement)

    return create


def companions(path: Path) -> list[Path]:
    """Files that SQLite keeps beside one, without which, or beside another file, its content is not whole."""
    return [path.with_name(path.name + end) for end in ("-wal", "-shm", "-journal")]


def delete(path: Path) -> None:
    """Remove a file with its companions.  Raises OSError."""
    for each in (path, *companions(path)):
        each.unlink(missing_ok=True)


def _has_content(path: Path) -> bool:
    """Whether there is such a file, and it is not empty, as a rollback journal is between transactions."""
    return path.exists() and path.stat().st_size > 0


def _names(path: Path) -> str:
    return ", ".join(each.name for each in companions(path))


def _bare(title: str) -> str:
    return title.removeprefix("the ")


def _identity(path: Path) -> tuple[int, int]:
    """Which file has that name.  Raises OSError."""
    found = path.stat()
    return found.st_dev, found.st_ino
