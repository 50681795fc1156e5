"""The folder of a daemon: one place for each kind of file that it makes."""

from __future__ import annotations

import fcntl
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from drivers.errors import InputError

from .recovery import recover


@dataclass(frozen=True)
class DataFolder:
    """Where a daemon keeps what it makes; `lock` is held as long as the process lives."""

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
    lock: TextIO


def open_data_folder(folder: Path) -> DataFolder:
    """The folders, made if missing; series that a crash left behind are put together first.

    Raises InputError if another daemon works in this folder, OSError if it cannot be made.
    """
    names = (
        *("recordings", "fits", "diagnoses", "characterisations", "procedures", "models", "calibrations"),
        *("jobs", "resonators", "sequences", "presets"),
    )
    for name in names:
        (folder / name).mkdir(parents=True, exist_ok=True)
    lock = (folder / ".lock").open("w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        lock.close()
        remedy = "stop it, or give this one another --data folder"
        raise InputError("another daemon works in this folder", where=str(folder), remedy=remedy) from None
    made = DataFolder(**{name: folder / name for name in names}, lock=lock)
    recover(made.recordings)
    return made
