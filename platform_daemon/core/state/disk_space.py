"""Can the disk take what is to be measured?  Checked before anything moves."""

from __future__ import annotations

import os
import shutil
from contextlib import suppress
from pathlib import Path
from secrets import token_hex

from .durable import PART
from .errors import StorageUnusable

SPARE_BYTES, SPARE_FILES = 64 << 20, 32
"""Left for records of jobs, results and logs."""
_PROBE = b"can this folder keep what it is given?"


def check_free_space(folder: Path, needed_bytes: int, shots: int = 0) -> None:
    """Raises StorageUnusable: too little room, no right to write, or a disk that does not keep what it is given.

    needed_bytes: of the recording; twice that must be free, because the files of its shots and the recording exist
    together for a moment.  Compression is not counted on.  shots: each is a file of its own.
    """
    _probe(folder)
    check_room(folder, needed_bytes, shots)


def check_room(folder: Path, needed_bytes: int, shots: int = 0) -> None:
    """The same without writing anything, as a dry run needs it.  Raises StorageUnusable."""
    disk = os.statvfs(folder)
    if disk.f_files and disk.f_favail < shots + SPARE_FILES:  # 0: a file system that does not number them
        raise StorageUnusable(
            f"the recording may need {shots + SPARE_FILES} files, the disk takes {disk.f_favail} more",
            where=str(folder),
            why="every shot is a file of its own until the recording is put together",
            remedy="delete files that are not needed, or record fewer shots",
        )
    needed, free = 2 * needed_bytes + SPARE_BYTES, shutil.disk_usage(folder).free
    if free < needed:
        raise StorageUnusable(
            f"the recording may need {needed >> 20} MiB, {free >> 20} MiB are free",
            where=str(folder),
            why="the files of the shots and the recording exist together for a moment",
            remedy="free the disk, or record fewer or shorter shots",
        )


def _probe(folder: Path) -> None:
    """Write a few bytes and have them on the disk."""
    file = folder / f".probe.{os.getpid()}-{token_hex(4)}{PART}"
    try:
        descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
        try:
            os.write(descriptor, _PROBE)
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
    except OSError as error:
        raise StorageUnusable(
            "the folder cannot keep a recording",
            where=str(folder),
            why=error.strerror or str(error),
            remedy="free or repair the disk, or give the daemon a folder that it may write to",
        ) from None
    finally:
        with suppress(OSError):
            file.unlink()
