"""The folder of a daemon: one place for each kind of file that it makes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from platform_daemon.core.state.audit import AUDIT
from platform_daemon.core.state.durable import sweep
from platform_daemon.core.state.earlier_files import import_earlier_files
from platform_daemon.core.state.errors import StorageUnusable
from platform_daemon.core.state.folder_lock import LOCK, FolderLock, lock_folder
from platform_daemon.core.state.state_file import STATE
from platform_daemon.core.state.tokens import TOKENS

from .recovery import recover

_NAMES = (
    *("recordings", "fits", "diagnoses", "characterisations", "procedures", "models", "calibrations"),
    *("resonators", "sequences", "presets", "measurands", "reproductions"),
)
EVENTS, SEEN, MOUNTED, SCHEDULES = "events.db", "alarms.seen", "mounted.json", "schedules.db"


@dataclass(frozen=True)
class DataFolder:
    """Where a daemon keeps what it makes.

    Files of `tokens`, `audit`, `events`, `events_seen`, `state`, `mounted` and `schedules` need not exist; all other
    paths are folders.  lock: held as long as the process lives; None: another process holds it.
    """

    recordings: Path
    fits: Path
    diagnoses: Path
    characterisations: Path
    procedures: Path
    models: Path
    calibrations: Path
    measurands: Path
    resonators: Path
    sequences: Path
    presets: Path
    reproductions: Path
    tokens: Path
    audit: Path
    events: Path
    events_seen: Path
    state: Path
    mounted: Path
    schedules: Path
    lock: FolderLock | None


def is_data_folder(folder: Path) -> bool:
    """Whether a daemon has worked there."""
    return (folder / LOCK).exists()


def open_data_folder(folder: Path, locked: Callable[[], None] = lambda: None) -> DataFolder:
    """The paths of a data folder, whose folders are made if missing.

    Series that a crash left behind are assembled, and files of earlier versions are imported.  A daemon there that has
    lost its parent is waited for.  locked: called once the folder is this process's, before anything in it is changed,
    so that the log can be kept of what is put together.  Raises InputError if another one works in this folder,
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
    locked()
    import_earlier_files(folder)
    made = data_paths(folder, lock)
    sweep([folder, *(folder / name for name in _NAMES)])
    recover(made.recordings)
    return made


def data_paths(folder: Path, lock: FolderLock | None = None) -> DataFolder:
    """The paths of a data folder that another process has opened; nothing is made or read."""
    named = {
        "tokens": TOKENS,
        "audit": AUDIT,
        "events": EVENTS,
        "events_seen": SEEN,
        "state": STATE,
        "mounted": MOUNTED,
        "schedules": SCHEDULES,
    }
    files = {name: folder / file for name, file in named.items()}
    return DataFolder(**{name: folder / name for name in _NAMES}, **files, lock=lock)
