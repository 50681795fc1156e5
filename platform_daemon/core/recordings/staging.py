"""The staging folder of a running series: `.<name>.shots/` in the folder of the series file, locked by its writer.

.thread.h5.shots/
    lock                held with flock for as long as the writer lives; the kernel frees it even after kill -9
    shot_000001.h5      acknowledged shots, each a recording of its own
    .shot_000002.h5.*.part  being written; worthless after a crash
    series.part         the series file being put together; worthless after a crash
"""

from __future__ import annotations

import fcntl
import os
import secrets
import shutil
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from drivers.errors import InputError
from platform_daemon.core.state.durable import PART

SUFFIX = ".shots"
_FRESH = ".shots-new-"
_FRESH_LIFETIME_S = 60.0


@dataclass(frozen=True)
class Staging:
    """A staging folder whose lock this process holds.  `lock` is an open file: closing it gives the folder free."""

    folder: Path
    lock: BinaryIO

    def shot_file(self, number: int) -> Path:
        """Where shot `number` (from 1) lives."""
        return shot_in(self.folder, number)

    def shots(self) -> list[Path]:
        """The acknowledged shots, in order."""
        return sorted(self.folder.glob("shot_*.h5"))

    @property
    def part(self) -> Path:
        """Where the series file is put together."""
        return self.folder / f"series{PART}"

    @property
    def target(self) -> Path:
        """The series file that these shots belong to."""
        return target_of(self.folder)

    def release(self) -> None:
        """Give the lock free; the shots stay."""
        self.lock.close()

    def remove(self) -> None:
        """Delete everything, then give the lock free.  Call only when the shots are safe elsewhere.

        The folder is renamed first, so that the remaining shots are never taken for the whole series.
        """
        nameless = _fresh(self.target)
        try:
            os.rename(self.folder, nameless)
        except OSError:
            nameless = self.folder
        shutil.rmtree(nameless, ignore_errors=True)
        self.lock.close()


def shot_in(folder: Path, number: int) -> Path:
    """Where shot `number` (from 1) lives in a staging folder."""
    return folder / f"shot_{number:06d}.h5"


def folder_of(target: Path) -> Path:
    """The staging folder of a series file."""
    return target.with_name(f".{target.name}{SUFFIX}")


def staging_folders(folder: Path) -> Iterator[Path]:
    """Those of series that run, or were cut off."""
    if folder.is_dir():
        yield from (each for each in sorted(folder.glob(f".*{SUFFIX}")) if each.is_dir() and not each.is_symlink())


def target_of(folder: Path) -> Path:
    """The series file of a staging folder."""
    return folder.with_name(folder.name.removeprefix(".").removesuffix(SUFFIX))


def claim(target: Path) -> Staging:
    """A new staging folder, already locked when it appears under its name.

    Raises InputError if the folder of `target` is missing or not writable, or another series to it is running.
    """
    fresh, folder = _fresh(target), folder_of(target)
    try:
        fresh.mkdir()
        lock = _locked(fresh)
        if lock is None:
            raise BlockingIOError("the new folder is locked already")
        # Onto an empty folder a rename succeeds: that is the last trace of a removal that was cut short.
        os.rename(fresh, folder)
    except OSError as error:
        shutil.rmtree(fresh, ignore_errors=True)
        if folder.exists():
            raise busy(target) from None
        why = error.strerror or str(error)
        remedy = "create the folder, or choose one that you may write to"
        raise InputError("cannot record here", where=str(target.parent), why=why, remedy=remedy) from None
    return Staging(folder, lock)


def _fresh(target: Path) -> Path:
    """A name that none of these folders has, and that says who made it."""
    return target.with_name(f".{target.name}{_FRESH}{os.getpid()}-{secrets.token_hex(4)}")


def busy(target: Path) -> InputError:
    """The error for a target that another writer is filling."""
    why = "Another process is recording to it"
    return InputError("the file is in use", where=str(target), why=why, remedy="wait, or choose another name")


def claim_abandoned(folder: Path) -> Staging | None:
    """An existing staging folder, locked for us; None if there is none or its writer lives."""
    lock = _locked(folder) if folder.is_dir() else None
    return None if lock is None else Staging(folder, lock)


def abandoned_series(folder: Path) -> Iterator[Staging]:
    """Every staging folder in `folder` whose writer has ended; each is locked while it is yielded."""
    for path in sorted(folder.glob(f".*{_FRESH}*")):
        if time.time() - path.stat().st_mtime > _FRESH_LIFETIME_S or _maker_is_dead(path):
            shutil.rmtree(path, ignore_errors=True)
    for path in sorted(folder.glob(f".*{SUFFIX}")):
        found = claim_abandoned(path)
        if found is not None:
            yield found


def _maker_is_dead(fresh: Path) -> bool:
    """Of a folder that never got its name."""
    pid, named, _ = fresh.name.rpartition(_FRESH)[2].partition("-")
    return bool(named) and pid.isdigit() and not Path("/proc", pid).exists()


def _locked(folder: Path) -> BinaryIO | None:
    """The locked file; None: its owner lives or has just removed it, or the folder of another user hides that."""
    file = _opened(folder / "lock")
    if file is None:
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        return None
    if not folder.is_dir() or not (folder / "lock").exists():
        file.close()
        return None
    return file


def _opened(lock: Path) -> BinaryIO | None:
    with suppress(OSError):
        return lock.open("ab")
    with suppress(OSError):  # of a disk that is read-only
        return lock.open("rb")
    return None
