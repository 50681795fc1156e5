"""The lock of a data folder, which says who started its holder: one whose parent has died is about to end."""

from __future__ import annotations

import fcntl
import os
import time
from contextlib import suppress
from pathlib import Path
from typing import TextIO

import psutil

from drivers.errors import InputError

LOCK = ".lock"
DYING_S = 30.0
"""A holder whose parent has died switches outputs off and puts its series together first."""
_LOOK_S = 0.1


def lock_folder(folder: Path) -> TextIO:
    """Held as long as the file is open.  Waits for one that is about to end.

    Raises InputError if another daemon works there, OSError if the file cannot be made.
    """
    file = (folder / LOCK).open("a+")
    until = time.monotonic() + DYING_S
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if _parent_lives(file) or time.monotonic() > until:
                file.close()
                remedy = "stop it, or give this one another --data folder"
                raise InputError("another daemon works in this folder", where=str(folder), remedy=remedy) from None
            time.sleep(_LOOK_S)
        else:
            break
    file.seek(0)
    file.truncate()
    with suppress(psutil.Error):  # it may be in a world of its own
        file.write(f"{os.getppid()} {psutil.Process(os.getppid()).create_time()}")
        file.flush()
    return file


def _parent_lives(file: TextIO) -> bool:
    """Also if nothing can be read of it."""
    file.seek(0)
    try:
        number, created = file.read().split()
        parent = psutil.Process(int(number))
        alive = parent.status() != psutil.STATUS_ZOMBIE
        return alive and abs(parent.create_time() - float(created)) < 1.0
    except ValueError:
        return True
    except psutil.Error:
        return False
