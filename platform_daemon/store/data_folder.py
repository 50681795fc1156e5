"""The folder of a daemon: one place for each kind of file that it makes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .access_files import AUDIT, TOKENS
from .errors import StorageUnusable
from .folder_lock import LOCK, FolderLock, lock_folder
from .leftovers import sweep
from .recovery import recover

_NAMES = (
    *("recordings", "fits", "diagnoses", "characterisations", "procedures", "models", "calibrations"),
    *("jobs", "resonators", "sequences", "presets"),
)
EVENTS, ALARMS, MOUNTED = "events.db", "alarms.json", "mounted.json"


@dataclass(frozen=True)
class DataFolder:
    """Where a daemon keeps what it makes: folders, the files `tokens`, `audit`, `events`, `alarms` and `mounted`, which
    need not exist; `lock` is held as long as the process lives, None: by another one."""

    recordings: Path
    fits: Path
    diagnoses: Path
    characterisations: Path
    procedures: Path
    models: Path
    calibrations: Path
    jobs: Path
    resonators: Path
    sequences: Path
    presets: Path
    tokens: Path
    audit: Path
    events: Path
    alarms: Path
    mounted: Path
    lock: FolderLock | None


def is_data_folder(folder: Path) -> bool:
    """Has a daemon worked there?"""
    return (folder / LOCK).exists()


def open_data_folder(folder: Path) -> DataFolder:
    """The folders, made if missing; series that a crash left behind are put together first.

    A daemon there that has lost its parent is waited for.  Raises InputError if another one works in this folder,
    StorageUnusable if it cannot be made or written to.
    """
    try:
        for name in _NAMES:
            (folder / name).mkdir(parents=True, exist_ok=True)
        lock = lock_folder(folder)
    except OSError as error:
        why = error.strerror or str(error)
        remedy = "free or repair the disk, or give another --data folder, which this account may write to"
        raise StorageUnusable("the data folder cannot be used", where=str(folder), why=why, remedy=remedy) from None
    made = data_paths(folder, lock)
    sweep([folder, *(folder / name for name in _NAMES)])
    recover(made.recordings)
    return made


def data_paths(folder: Path, lock: FolderLock | None = None) -> DataFolder:
    """Where everything is in a folder that another process has opened; nothing is made or looked at."""
    named = {"tokens": TOKENS, "audit": AUDIT, "events": EVENTS, "alarms": ALARMS, "mounted": MOUNTED}
    files = {name: folder / file for name, file in named.items()}
    return DataFolder(**{name: folder / name for name in _NAMES}, **files, lock=lock)
