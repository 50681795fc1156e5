"""The index of the recordings: values of many files that a query compares, in SQLite.

The index holds nothing that the files do not say, so one that is missing, damaged or of another version is made again
from them.  Several processes may read and write it.
"""

from __future__ import annotations

import contextlib
import json
import os
import sqlite3
import tempfile
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import structlog

from drivers.errors import RecordingError
from platform_daemon.core.recordings.index import Entry, recording_files
from platform_daemon.core.schemas.text import same_name
from platform_daemon.core.state.database import Database, Schema, WhenDamaged, delete, tables
from platform_daemon.core.state.durable import storage_error
from platform_daemon.core.state.errors import IndexUnfinished, RecordingNotNow

from .indexed import (
    IndexedPoint,
    IndexedRecording,
    IndexedShot,
    IndexedSpecimen,
    IndexedSummary,
    IndexUpdate,
    Wanted,
)

INDEX = ".index.db"
"""Name of the file in the folder of the recordings; no recording has such a name."""
log = structlog.get_logger()
_ELSEWHERE: dict[Path, tempfile.TemporaryDirectory[str]] = {}  # by the folder of the recordings
_COLUMNS = "identifier, begun, specimen, operator, frames, good, calibration, fit, resonator, step, clock"
_TABLES = """
CREATE TABLE recordings (identifier TEXT PRIMARY KEY, file TEXT NOT NULL, size INTEGER NOT NULL,
    modified INTEGER NOT NULL, error TEXT, begun TEXT, specimen TEXT, operator TEXT, frames INTEGER, good INTEGER,
    calibration TEXT, fit TEXT, resonator TEXT, step TEXT, clock TEXT, listed TEXT);
CREATE INDEX by_specimen ON recordings (specimen, begun);
CREATE TABLE tags (recording TEXT NOT NULL, tag TEXT NOT NULL, PRIMARY KEY (recording, tag)) WITHOUT ROWID;
CREATE TABLE shots (recording TEXT NOT NULL, frame INTEGER NOT NULL, at TEXT NOT NULL, temperature REAL, field REAL,
    fitted TEXT NOT NULL, PRIMARY KEY (recording, frame)) WITHOUT ROWID;
CREATE TABLE points (recording TEXT NOT NULL, number INTEGER NOT NULL, at TEXT NOT NULL, shots INTEGER NOT NULL,
    temperature REAL, field REAL, fitted TEXT NOT NULL, PRIMARY KEY (recording, number)) WITHOUT ROWID
"""
_NEVER_NS = -1
"""The modification time in the row of a file that must be read again: no file has it."""
_UNFINISHED = "unfinished"
"""A table that exists until all files have been read once: until then answers would leave some out."""

Look = Callable[[Path], tuple[IndexedRecording, Sequence[IndexedShot]] | None]
"""Reads what the index holds of a file; None: nothing, as of a file of another program.  Raises RecordingError."""


def open_index(folder: Path, *, rebuild: bool = False) -> RecordingIndex:
    """The index of a folder of recordings, made if missing, not brought up to date; rebuild: delete its content first.

    Raises StorageError.

    Example:
        >>> with contextlib.closing(open_index(Path("data/recordings"))) as index:
        ...     index.find(Wanted(specimen="A7"))
    """
    return RecordingIndex(_place(folder), folder, rebuild=rebuild)


def _place(folder: Path) -> Path:
    """Where the index is kept: with the recordings; where this account may not write there, as on a disk that is
    read-only, in a folder of this process, because whoever only looks needs no more than to read."""
    index = folder / INDEX
    if not folder.is_dir() or (os.access(folder, os.W_OK) and (not index.exists() or os.access(index, os.W_OK))):
        return index
    place = folder.resolve()
    if place not in _ELSEWHERE:
        _ELSEWHERE[place] = tempfile.TemporaryDirectory(prefix="mmr-index-")
    return Path(_ELSEWHERE[place].name) / INDEX


class RecordingIndex:
    """The index at `path` of the recordings in `folder`; rebuild: delete its content first.

    Every method raises StorageError where the file cannot be used; queries raise IndexUnfinished as long as the index
    was never brought up to date.
    """

    def __init__(self, path: Path, folder: Path, *, rebuild: bool = False) -> None:
        self._path, self._folder = path, folder
        schema = Schema(
            title="the index of the recordings",
            application_id=0x4D4D5249,  # "MMRI"
            version=9,
            create=self._create,
            when_damaged=WhenDamaged.DELETE,
            remedy="free or repair the disk, then platform-daemon index rebuild; no recording is lost",
        )
        if rebuild:
            try:
                delete(path)
            except OSError as error:
                raise storage_error(path, error) from error
        self._file = Database(path, schema)
        self._file.add_function("folded", _folded)  # SQLite's lower() knows ASCII only

    def _create(self, sql: sqlite3.Connection) -> None:
        tables(_TABLES)(sql)
        if any(recording_files(self._folder)):
            sql.execute(f"CREATE TABLE {_UNFINISHED} (files)")

    @property
    def damaged(self) -> bool:
        """Whether a query has found that the file is damaged."""
        return self._file.damaged

    def close(self) -> None:
        """Idempotent."""
        self._file.close()

    def update(self, look: Look, done: Callable[[int, int], None] = lambda n, of: None) -> IndexUpdate:
        """Read the files that are new or have changed, and remove those that were deleted.

        A file that cannot be read is kept with the reason, and read again when it has changed; one that is in use, or
        that this account may not read now, is read again the next time.  look: reads one file; done: called with how
        many files were read, and of how many.
        """
        known = {row[0]: row[1:] for row in self._file.rows("SELECT identifier, file, size, modified FROM recordings")}
        there: dict[str, tuple[str, int, int]] = {}
        for path in recording_files(self._folder):
            with contextlib.suppress(FileNotFoundError):
                stat = path.stat()
                there.setdefault(path.stem, (path.name, stat.st_size, stat.st_mtime_ns))
        deleted = [name for name in known if name not in there]
        new = [name for name, facts in there.items() if known.get(name) != facts]
        touched = {self._specimen(name) for name in (*deleted, *new)}
        with self._file.transaction() as sql:
            for name in deleted:
                _remove(sql, name)
        in_use = 0
        for n, name in enumerate(new):
            done(n, len(new))
            in_use += self._look_at(name, there[name], look)
        if not self.finished:
            with self._file.transaction() as sql:
                sql.execute(f"DROP TABLE IF EXISTS {_UNFINISHED}")
        done(len(new), len(new))
        touched |= {self._specimen(name) for name in new}
        return IndexUpdate(len(new), frozenset(touched - {""}), in_use)

    def _specimen(self, name: str) -> str:
        """Name of the specimen of a recording, "" if it is not known."""
        found = self._file.rows("SELECT specimen FROM recordings WHERE identifier = ?", (name,))
        return (found and found[0][0]) or ""

    def _look_at(self, name: str, facts: tuple[str, int, int], look: Look) -> bool:
        """Read a file, and keep what it holds or why it cannot be read; True: it is in use, and must be read again."""
        found: IndexedRecording | None = None
        shots: Sequence[IndexedShot] = ()
        error, in_use = None, False
        try:
            found, shots = look(self._folder / facts[0]) or (None, ())
        except Exception as failure:  # one file must not end the index of all others
            error = str(failure) or type(failure).__name__
            in_use = isinstance(failure, (RecordingNotNow, OSError, MemoryError))
            if not isinstance(failure, RecordingError):
                log.error("recording_not_looked_at", file=facts[0], exc_info=failure)
        if in_use:
            facts = (facts[0], facts[1], _NEVER_NS)
            with self._file.transaction() as sql:  # what is known of it stays
                known = "UPDATE recordings SET modified = ? WHERE identifier = ? AND begun IS NOT NULL"
                if sql.execute(known, (_NEVER_NS, name)).rowcount:
                    return True
        row: tuple[object, ...] = (name, *facts, error, *(None,) * 11)
        if found is not None:
            said = (found.begun, found.specimen, found.operator, found.frames, found.good, found.calibration, found.fit)
            row = (name, *facts, error, *said, found.resonator, found.step, found.clock, _listed(found))
        with self._file.transaction() as sql:
            _remove(sql, name)
            sql.execute(f"INSERT INTO recordings VALUES ({', '.join('?' * 16)})", row)
            if found is not None:
                _insert(sql, found, shots)
        return in_use

    def find(self, wanted: Wanted) -> Sequence[str]:
        """Names of the files that match, sorted; files that cannot be read are left out."""
        w = wanted
        conditions = {
            "specimen = ?": w.specimen,
            "instr(folded(operator), folded(?)) > 0": w.operator,
            "begun >= ?": w.since,
            "begun <= ?": w.until,
            "(good < frames) = ?": w.refused,
            "identifier IN (SELECT recording FROM tags WHERE tag = ?)": w.tag and _folded(w.tag.removeprefix("#")),
            "resonator = ?": w.resonator,
        }
        used = {text: value for text, value in conditions.items() if value is not None}
        query = f"SELECT file FROM recordings WHERE {' AND '.join(['begun IS NOT NULL', *used])} ORDER BY file"
        return [row[0] for row in self._all_rows(query, tuple(used.values()))]

    def entries(self, paths: Sequence[Path]) -> dict[Path, Entry]:
        """What a list says of these files, without those that are new, have changed or are none of ours."""
        query = f"SELECT file, size, modified, listed FROM recordings WHERE file IN ({', '.join('?' * len(paths))})"
        rows = {row[0]: row[1:] for row in self._file.rows(query, tuple(path.name for path in paths))}
        found = {}
        for path in paths:
            with contextlib.suppress(FileNotFoundError):
                stat = path.stat()
                *facts, listed = rows.get(path.name, (None, None, None))
                if listed is not None and facts == [stat.st_size, stat.st_mtime_ns]:
                    found[path] = Entry(path=path, **json.loads(listed))
        return found

    def specimens(self) -> Sequence[str]:
        """Names of all specimens with a shot that was fitted."""
        query = "SELECT DISTINCT specimen FROM recordings WHERE fit IS NOT NULL ORDER BY specimen"
        return [row[0] for row in self._all_rows(query)]

    def recordings(self, specimen: str, since: str = "", until: str = "\uffff") -> Sequence[IndexedRecording]:
        """Recordings of a specimen with fits, oldest first; between two times, ISO 8601 in UTC."""
        query = (
            "SELECT {} FROM recordings"
            " WHERE specimen = ? AND fit IS NOT NULL AND begun >= ? AND begun <= ? ORDER BY begun, identifier"
        )
        values = (specimen, since, until)
        found = self._all_rows(query.format(_COLUMNS), values)
        tags: dict[str, set[str]] = defaultdict(set)
        points: dict[str, list[IndexedPoint]] = defaultdict(list)
        among = f"recording IN ({query.format('identifier')})"
        for name, tag in self._file.rows(f"SELECT recording, tag FROM tags WHERE {among}", values):
            tags[name].add(tag)
        of_all = f"SELECT recording, at, shots, temperature, field, fitted FROM points WHERE {among} ORDER BY number"
        rows = self._file.rows(of_all, values)
        fitted = json.loads(f"[{','.join(text for *_, text in rows)}]")  # at once: calls take as long again
        for (name, at, n, warm, field_t, _), figures in zip(rows, fitted, strict=True):
            points[name].append(IndexedPoint(at, n, warm, field_t, figures))
        columns = [dict(zip(_COLUMNS.split(", "), row, strict=True)) for row in found]
        return [
            IndexedRecording(**each, tags=frozenset(tags[each["identifier"]]), points=points[each["identifier"]])
            for each in columns
        ]

    def specimen(self, name: str) -> IndexedSpecimen | None:
        """What its page says of a specimen; None: no recording of it has fits."""
        of_it = "FROM recordings WHERE specimen = ? AND fit IS NOT NULL"
        found = self._all_rows(
            f"SELECT identifier, begun, resonator, calibration {of_it} ORDER BY begun, identifier", (name,)
        )
        if not found:
            return None
        among = f"WHERE recording IN (SELECT identifier {of_it})"
        ((shots,),) = self._file.rows(f"SELECT total(shots) FROM points {among}", (name,))
        tags = self._file.rows(f"SELECT DISTINCT tag FROM tags {among} ORDER BY tag", (name,))
        return IndexedSpecimen(
            identifiers=[row[0] for row in found],
            first=found[0][1],
            last=found[-1][1],
            shots=int(shots),
            resonators=Counter(row[2] for row in reversed(found)),
            calibrations=Counter(row[3] for row in found if row[3] is not None),
            tags=[tag for (tag,) in tags],
        )

    def summaries(self, identifiers: Sequence[str]) -> dict[str, IndexedSummary]:
        """What a list says of these recordings, by id, without those that are not in the index or cannot be read."""
        query = f"""
            SELECT r.identifier, r.specimen, r.resonator, r.good, r.frames - r.good,
                   {_mean("f_nat_hz")}, {_mean("m_r_am2")}
            FROM recordings r LEFT JOIN points p ON p.recording = r.identifier
            WHERE r.begun IS NOT NULL AND r.identifier IN ({", ".join("?" * len(identifiers))})
            GROUP BY r.identifier"""
        return {
            name: IndexedSummary(specimen or None, resonator or None, *rest)
            for name, specimen, resonator, *rest in self._all_rows(query, tuple(identifiers))
        }

    def newest(self, specimen: str, count: int) -> Sequence[str]:
        """Ids of the newest `count` recordings of a specimen with fits, newest last."""
        query = (
            "SELECT identifier FROM recordings WHERE specimen = ? AND fit IS NOT NULL"
            " ORDER BY begun DESC, identifier DESC LIMIT ?"
        )
        return [row[0] for row in reversed(self._all_rows(query, (specimen, count)))]

    def files(self) -> Sequence[tuple[str, int, str, str, frozenset[str]]]:
        """File, bytes, begin, specimen and tags of every recording that can be read, oldest first."""
        query = "SELECT file, size, begun, specimen, identifier FROM recordings WHERE begun IS NOT NULL ORDER BY begun"
        found = self._all_rows(query)
        tags: dict[str, set[str]] = defaultdict(set)
        for name, tag in self._file.rows("SELECT recording, tag FROM tags"):
            tags[name].add(tag)
        return [(*row[:4], frozenset(tags[row[4]])) for row in found]

    def shots(self, recording: str) -> Sequence[IndexedShot]:
        """Shots of one recording, by its id."""
        query = "SELECT frame, at, temperature, field, fitted FROM shots WHERE recording = ? ORDER BY frame"
        found = self._file.rows(query, (recording,))
        return [IndexedShot(k, at, warm, field_t, json.loads(text)) for k, at, warm, field_t, text in found]

    def broken(self) -> Mapping[str, str]:
        """Files that cannot be read, by id, each with the reason."""
        return dict(self._file.rows("SELECT identifier, error FROM recordings WHERE error IS NOT NULL"))

    @property
    def finished(self) -> bool:
        """Whether all files have been read once."""
        return not self._file.rows("SELECT 1 FROM sqlite_master WHERE name = ?", (_UNFINISHED,))

    def _all_rows(self, query: str, values: Sequence[object] = ()) -> list[Any]:
        """Raises IndexUnfinished."""
        if not self.finished:
            what, why = "the index of the recordings is being made", "it was missing, damaged or of another version"
            raise IndexUnfinished(what, where=str(self._path), why=why, remedy="repeat the request in some seconds")
        return self._file.rows(query, values)


def _folded(text: str) -> str:
    return same_name(text).casefold()


def _listed(found: IndexedRecording) -> str | None:
    return None if found.listed is None else json.dumps({k: v for k, v in asdict(found.listed).items() if k != "path"})


def _mean(name: str) -> str:
    """SQL: the mean of a parameter over the shots of all points that have it; null if none has."""
    value = f"json_extract(p.fitted, '$.{name}')"
    return f"SUM(p.shots * {value}) / SUM(CASE WHEN {value} IS NOT NULL THEN p.shots END)"


def _insert(sql: sqlite3.Connection, found: IndexedRecording, shots: Sequence[IndexedShot]) -> None:
    """Tags, points and shots of a recording."""
    name = found.identifier
    for tag in sorted(found.tags):
        sql.execute("INSERT INTO tags VALUES (?, ?)", (name, tag))
    for n, p in enumerate(found.points):
        point = (name, n, p.at, p.shots, p.temperature_c, p.field_t, json.dumps(dict(p.values)))
        sql.execute("INSERT INTO points VALUES (?, ?, ?, ?, ?, ?, ?)", point)
    for s in shots:
        shot = (name, s.frame, s.at, s.temperature_c, s.field_t, json.dumps(dict(s.values)))
        sql.execute("INSERT INTO shots VALUES (?, ?, ?, ?, ?, ?)", shot)


def _remove(sql: sqlite3.Connection, name: str) -> None:
    """All rows of a recording."""
    for table in ("shots", "points", "tags"):
        sql.execute(f"DELETE FROM {table} WHERE recording = ?", (name,))
    sql.execute("DELETE FROM recordings WHERE identifier = ?", (name,))
