"""Import of files that earlier versions of the daemon kept: a file for each job, and one for the alarms.

Rows are added in one transaction, then the files are moved to `before-state`.  An import that is killed in between is
made again at the next start: a row that is there already is left as it is.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterator
from pathlib import Path

import structlog

from .database import Database
from .durable import storage_error, sweep, sync
from .errors import StorageError
from .state_file import STATE, STATE_SCHEMA

log = structlog.get_logger()
_JOBS, _ALARMS = "jobs", "alarms.json"
BEFORE = "before-state"
"""Folder of the data folder for files that were imported; it may be deleted."""
UNREADABLE = "unreadable"
"""State of a job whose record says none."""


def import_earlier_files(folder: Path) -> None:
    """Import the files of a data folder that no other process uses; what is refused is logged, and tried again later.

    A disk that refuses leaves all files as they are.
    """
    jobs, alarms = sorted((folder / _JOBS).glob("[!.]*.json")), folder / _ALARMS
    if jobs or alarms.exists():
        _import(folder, jobs, alarms)
    sweep([folder / _JOBS])
    with contextlib.suppress(OSError):  # it is not there, or not empty
        (folder / _JOBS).rmdir()


def _import(folder: Path, jobs: list[Path], alarms: Path) -> None:
    try:
        database = Database(folder / STATE, STATE_SCHEMA)
        try:
            with database.transaction() as sql:
                sql.executemany("INSERT OR IGNORE INTO jobs (id, state, record) VALUES (?, ?, ?)", map(_job, jobs))
                sql.executemany("INSERT OR IGNORE INTO alarms (name, alarm) VALUES (?, ?)", _alarms(alarms))
        finally:
            database.close()
        _move(folder, [*jobs, *([alarms] if alarms.exists() else [])])
    except (StorageError, OSError) as error:
        refused = error if isinstance(error, StorageError) else storage_error(folder / BEFORE, error)
        log.error("earlier_files_not_imported", folder=str(folder), error=str(refused))
        return
    log.info("earlier_files_imported", folder=str(folder), jobs=len(jobs), kept=BEFORE)


def _job(path: Path) -> tuple[str, str, str]:
    """Id, state and record; of one that is cut off or of another version the record is kept as it is."""
    text = path.read_text(encoding="utf-8", errors="replace")
    try:
        state = str(json.loads(text)["state"])
    except (ValueError, TypeError, KeyError):
        state = UNREADABLE
    return path.stem, state, text


def _alarms(path: Path) -> Iterator[tuple[str, str]]:
    try:
        found = [(str(each["name"]), json.dumps(each)) for each in json.loads(path.read_bytes())]
    except FileNotFoundError:
        return
    except (ValueError, TypeError, KeyError) as error:  # an alarm that still holds is raised again
        log.error("alarms_not_read", file=str(path), error=str(error))
        return
    yield from found


def _move(folder: Path, files: list[Path]) -> None:
    """Raises OSError."""
    for file in files:
        target = folder / BEFORE / file.relative_to(folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(file, target)
    parents = {file.parent for file in files}
    for parent in (*parents, *(folder / BEFORE / each.relative_to(folder) for each in parents)):
        sync(parent)
