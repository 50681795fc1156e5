"""The index of the recordings: what is asked of many files at once, in SQLite.

It holds nothing that the files do not say: one that is missing, broken or of another version is made anew from them.
Several processes may read and write it.
"""

from __future__ import annotations

import contextlib
import json
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import structlog

from drivers.errors import RecordingError

from .errors import IndexUnfinished, StorageError
from .index import recording_files
from .indexed import IndexedPoint, IndexedRecording, IndexedShot, IndexUpdate, Wanted

INDEX = ".index.db"
"""In the folder of the recordings: a name that no recording has."""
log = structlog.get_logger()
_APPLICATION, _VERSION, _BUSY_S = 0x4D4D5249, 5, 10.0  # "MMRI"
_COLUMNS = "identifier, begun, specimen, operator, frames, good, calibration, fit, resonator"
_TABLES = """
CREATE TABLE recordings (identifier TEXT PRIMARY KEY, file TEXT NOT NULL, size INTEGER NOT NULL,
    modified INTEGER NOT NULL, error TEXT, begun TEXT, specimen TEXT, operator TEXT, frames INTEGER, good INTEGER,
    calibration TEXT, fit TEXT, resonator TEXT);
CREATE INDEX by_specimen ON recordings (specimen, begun);
CREATE TABLE tags (recording TEXT NOT NULL, tag TEXT NOT NULL, PRIMARY KEY (recording, tag)) WITHOUT ROWID;
CREATE TABLE shots (recording TEXT NOT NULL, frame INTEGER NOT NULL, at TEXT NOT NULL, temperature REAL, field REAL,
    fitted TEXT NOT NULL, PRIMARY KEY (recording, frame)) WITHOUT ROWID;
CREATE TABLE points (recording TEXT NOT NULL, number INTEGER NOT NULL, at TEXT NOT NULL, shots INTEGER NOT NULL,
    temperature REAL, field REAL, fitted TEXT NOT NULL, PRIMARY KEY (recording, number)) WITHOUT ROWID;
"""
_UNFINISHED = "unfinished"
"""A table that is there until all files have been looked at once: until then answers would leave some out."""


Look = Callable[[Path], tuple[IndexedRecording, Sequence[IndexedShot]] | None]
"""What the index holds of a file; None: nothing, it is not one of ours.  Raises RecordingError."""


def open_index(folder: Path, *, anew: bool = False) -> RecordingIndex:
    """The index of a folder, made if missing, not brought up to date; anew: empty.  Raises StorageError."""
    return RecordingIndex(folder / INDEX, folder, anew=anew)


class RecordingIndex:
    """For one thread at a time.  folder: of the recordings; path: of the index; anew: forget what it holds; raises
    StorageError.  What is asked of one that was never brought up to date raises IndexUnfinished.

    damaged: what it holds could not be read.
    """

    def __init__(self, path: Path, folder: Path, *, anew: bool = False) -> None:
        self._path, self._folder, self.damaged = path, folder, False
        try:
            if anew:
                _forget(path)
            self._sql = _opened(path, folder)
        except (sqlite3.Error, OSError) as error:
            raise self._refused(error) from None

    def close(self) -> None:
        """Idempotent."""
        self._sql.close()

    def update(self, look: Look, done: Callable[[int, int], None] = lambda n, of: None) -> IndexUpdate:
        """Look at the files that are new or have changed, forget those that are gone.

        A file that cannot be read is kept with the reason, and looked at again when it has changed.  done: told how
        many of how many.  Raises StorageError.
        """
        known = {row[0]: row[1:] for row in self._rows("SELECT identifier, file, size, modified FROM recordings")}
        there: dict[str, tuple[str, int, int]] = {}
        for path in recording_files(self._folder):
            with contextlib.suppress(FileNotFoundError):
                stat = path.stat()
                there.setdefault(path.stem, (path.name, stat.st_size, stat.st_mtime_ns))
        gone = [name for name in known if name not in there]
        new = [name for name, facts in there.items() if known.get(name) != facts]
        touched = {self._specimen(name) for name in (*gone, *new)}
        with self._written():
            for name in gone:
                self._forget(name)
        for n, name in enumerate(new):
            done(n, len(new))
            self._look_at(name, there[name], look)
        if not self.finished:
            with self._written():
                self._sql.execute(f"DROP TABLE IF EXISTS {_UNFINISHED}")
        done(len(new), len(new))
        touched |= {self._specimen(name) for name in new}
        return IndexUpdate(len(new), frozenset(touched - {""}))

    def _specimen(self, name: str) -> str:
        """Whose recording it is, "" if nobody knows."""
        found = self._rows("SELECT specimen FROM recordings WHERE identifier = ?", (name,))
        return (found and found[0][0]) or ""

    def _look_at(self, name: str, facts: tuple[str, int, int], look: Look) -> None:
        found: IndexedRecording | None = None
        shots: Sequence[IndexedShot] = ()
        error = None
        try:
            found, shots = look(self._folder / facts[0]) or (None, ())
        except Exception as failure:  # one file must not end the index of all others
            error = str(failure) or type(failure).__name__
            if not isinstance(failure, RecordingError):
                log.error("recording_not_looked_at", file=facts[0], exc_info=failure)
        row: tuple[object, ...] = (name, *facts, error, *(None,) * 8)
        if found is not None:
            said = (found.begun, found.specimen, found.operator, found.frames, found.good, found.calibration, found.fit)
            row = (name, *facts, error, *said, found.resonator)
        with self._written():
            self._forget(name)
            self._sql.execute(f"INSERT INTO recordings VALUES ({', '.join('?' * 13)})", row)
            if found is not None:
                self._keep(found, shots)

    def _keep(self, found: IndexedRecording, shots: Sequence[IndexedShot]) -> None:
        name = found.identifier
        for tag in sorted(found.tags):
            self._sql.execute("INSERT INTO tags VALUES (?, ?)", (name, tag))
        for n, p in enumerate(found.points):
            point = (name, n, p.at, p.shots, p.temperature_c, p.field_t, json.dumps(dict(p.values)))
            self._sql.execute("INSERT INTO points VALUES (?, ?, ?, ?, ?, ?, ?)", point)
        for s in shots:
            shot = (name, s.frame, s.at, s.temperature_c, s.field_t, json.dumps(dict(s.values)))
            self._sql.execute("INSERT INTO shots VALUES (?, ?, ?, ?, ?, ?)", shot)

    def _forget(self, name: str) -> None:
        for table in ("shots", "points"):
            self._sql.execute(f"DELETE FROM {table} WHERE recording = ?", (name,))
        self._sql.execute("DELETE FROM tags WHERE recording = ?", (name,))
        self._sql.execute("DELETE FROM recordings WHERE identifier = ?", (name,))

    def find(self, wanted: Wanted) -> Sequence[str]:
        """Names of the files of what is looked for, sorted; files that cannot be read are never found."""
        w = wanted
        conditions = {
            "specimen = ?": w.specimen,
            "instr(folded(operator), folded(?)) > 0": w.operator,
            "begun >= ?": w.since,
            "begun <= ?": w.until,
            "(good < frames) = ?": w.refused,
            "identifier IN (SELECT recording FROM tags WHERE tag = ?)": w.tag and w.tag.removeprefix("#").casefold(),
            "resonator = ?": w.resonator,
        }
        used = {text: value for text, value in conditions.items() if value is not None}
        query = f"SELECT file FROM recordings WHERE {' AND '.join(['begun IS NOT NULL', *used])} ORDER BY file"
        return [row[0] for row in self._all_rows(query, tuple(used.values()))]

    def specimens(self) -> Sequence[str]:
        """Names of all specimens with a shot that was fitted."""
        query = "SELECT DISTINCT specimen FROM recordings WHERE fit IS NOT NULL ORDER BY specimen"
        return [row[0] for row in self._all_rows(query)]

    def recordings(self, specimen: str, since: str = "", until: str = "\uffff") -> Sequence[IndexedRecording]:
        """Recordings of a specimen with fits, oldest first; between two times, ISO 8601 in UTC."""
        query = (
            f"SELECT {_COLUMNS} FROM recordings"
            " WHERE specimen = ? AND fit IS NOT NULL AND begun >= ? AND begun <= ? ORDER BY begun, identifier"
        )
        found = self._all_rows(query, (specimen, since, until))
        made = [IndexedRecording(*row) for row in found]
        return [replace(m, tags=self._tags(m.identifier), points=self._points(m.identifier)) for m in made]

    def newest(self, specimen: str, count: int) -> Sequence[str]:
        """Ids of so many of its recordings with fits, newest last."""
        query = (
            "SELECT identifier FROM recordings WHERE specimen = ? AND fit IS NOT NULL"
            " ORDER BY begun DESC, identifier DESC LIMIT ?"
        )
        return [row[0] for row in reversed(self._all_rows(query, (specimen, count)))]

    def _tags(self, recording: str) -> frozenset[str]:
        return frozenset(row[0] for row in self._rows("SELECT tag FROM tags WHERE recording = ?", (recording,)))

    def files(self) -> Sequence[tuple[str, int, str, str, frozenset[str]]]:
        """File, bytes, begin, specimen and tags of every recording that can be read, oldest first."""
        query = "SELECT file, size, begun, specimen, identifier FROM recordings WHERE begun IS NOT NULL ORDER BY begun"
        return [(*row[:4], self._tags(row[4])) for row in self._all_rows(query)]

    def _points(self, recording: str) -> Sequence[IndexedPoint]:
        query = "SELECT at, shots, temperature, field, fitted FROM points WHERE recording = ? ORDER BY number"
        found = self._rows(query, (recording,))
        return [IndexedPoint(at, n, warm, field_t, json.loads(text)) for at, n, warm, field_t, text in found]

    def shots(self, recording: str) -> Sequence[IndexedShot]:
        """Those of one recording, by its id."""
        query = "SELECT frame, at, temperature, field, fitted FROM shots WHERE recording = ? ORDER BY frame"
        found = self._rows(query, (recording,))
        return [IndexedShot(k, at, warm, field_t, json.loads(text)) for k, at, warm, field_t, text in found]

    def broken(self) -> Mapping[str, str]:
        """Files that cannot be read, by id, each with the reason."""
        return dict(self._rows("SELECT identifier, error FROM recordings WHERE error IS NOT NULL"))

    @property
    def finished(self) -> bool:
        """Have all files been looked at once?  Raises StorageError."""
        return not self._rows("SELECT 1 FROM sqlite_master WHERE name = ?", (_UNFINISHED,))

    def _all_rows(self, query: str, values: Sequence[object] = ()) -> list[Any]:
        """Raises IndexUnfinished, StorageError."""
        if not self.finished:
            what, why = "the index of the recordings is being made", "it was missing, damaged or of another version"
            raise IndexUnfinished(what, where=str(self._path), why=why, remedy="ask again in some seconds")
        return self._rows(query, values)

    def _rows(self, query: str, values: Sequence[object] = ()) -> list[Any]:
        """Raises StorageError."""
        try:
            return self._sql.execute(query, values).fetchall()
        except sqlite3.Error as error:
            raise self._refused(error) from None

    @contextlib.contextmanager
    def _written(self) -> Iterator[None]:
        """Raises StorageError."""
        try:
            self._sql.execute("BEGIN IMMEDIATE")
            try:
                yield
            except BaseException:
                if self._sql.in_transaction:  # a full disk has rolled it back
                    self._sql.execute("ROLLBACK")
                raise
            self._sql.execute("COMMIT")
        except sqlite3.Error as error:
            raise self._refused(error) from None

    def _refused(self, error: Exception) -> StorageError:
        self.damaged = isinstance(error, sqlite3.DatabaseError) and not isinstance(error, sqlite3.OperationalError)
        what = "the index of the recordings cannot be used"
        remedy = "free or repair the disk, then platform-daemon index rebuild; no recording is lost"
        return StorageError(what, where=str(self._path), why=str(error), remedy=remedy)


def _opened(path: Path, folder: Path) -> sqlite3.Connection:
    """Raises sqlite3.Error, OSError."""
    try:
        return _connected(path, folder)
    except sqlite3.DatabaseError as error:
        if isinstance(error, sqlite3.OperationalError):  # the disk or a lock, not the file
            raise
        log.warning("index_made_anew", file=str(path), why=str(error))
        _forget(path)
        return _connected(path, folder)


def _forget(path: Path) -> None:
    for end in ("", "-wal", "-shm"):
        path.with_name(path.name + end).unlink(missing_ok=True)


def _connected(path: Path, folder: Path) -> sqlite3.Connection:
    sql = sqlite3.connect(path, isolation_level=None, check_same_thread=False, timeout=_BUSY_S)
    try:
        sql.create_function("folded", 1, str.casefold, deterministic=True)  # SQLite's lower() knows ASCII only
        sql.execute("PRAGMA journal_mode = WAL")
        sql.execute("PRAGMA synchronous = NORMAL")
        sql.execute("BEGIN IMMEDIATE")
        if sql.execute("SELECT count(*) FROM sqlite_master").fetchone()[0] == 0:
            for statement in _TABLES.split(";")[:-1]:
                sql.execute(statement)
            if any(recording_files(folder)):
                sql.execute(f"CREATE TABLE {_UNFINISHED} (files)")
            sql.execute(f"PRAGMA application_id = {_APPLICATION}")
            sql.execute(f"PRAGMA user_version = {_VERSION}")
        sql.execute("COMMIT")
        found = [sql.execute(f"PRAGMA {name}").fetchone()[0] for name in ("application_id", "user_version")]
        if found != [_APPLICATION, _VERSION]:
            raise sqlite3.DatabaseError(f"it is no index of version {_VERSION}")
    except BaseException:
        sql.close()
        raise
    return sql
