"""The lock of a data folder.  The file holds the process id of its holder's parent and when that one was started.

A process of the daemon whose parent has died is about to end, so the next daemon waits for it instead of being refused.
The folder itself is locked as well, so that a person who deletes the file as a supposed leftover does not unlock it.
"""

from __future__ import annotations

import fcntl
import os
import time
import weakref
from contextlib import suppress
from pathlib import Path
from typing import TextIO

import psutil

from drivers.errors import InputError

LOCK = ".lock"
DYING_S = 30.0
"""Longest time, s, that a holder whose parent has died takes to switch outputs off and to assemble its recording."""
_LOOK_S = 0.1


class FolderLock:
    """Held until it is closed, or its last owner has ended.  Raises OSError if the file cannot be made."""

    def __init__(self, folder: Path) -> None:
        self.file = (folder / LOCK).open("a+")
        number = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        self._folder, self._let_go = number, weakref.finalize(self, os.close, number)

    def take(self) -> None:
        """Raises BlockingIOError if another process holds it."""
        fcntl.flock(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        try:
            fcntl.flock(self._folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise
        except OSError:  # NFS locks only what is open for writing
            pass

    def close(self) -> None:
        """Idempotent."""
        self.file.close()
        self._let_go()


def lock_folder(folder: Path) -> FolderLock:
    """Lock a data folder, as long as the lock is kept.  Waits for a holder that is about to end.

    Raises InputError if another daemon works there, OSError if the file cannot be made.
    """
    lock = FolderLock(folder)
    file = lock.file
    until = time.monotonic() + DYING_S
    while True:
        try:
            lock.take()
        except BlockingIOError:
            if _parent_lives(file) or time.monotonic() > until:
                lock.close()
                remedy = "stop it, or give this one another --data folder"
                raise InputError("another daemon works in this folder", where=str(folder), remedy=remedy) from None
            time.sleep(_LOOK_S)
        else:
            break
    file.seek(0)
    file.truncate()
    with suppress(psutil.Error):  # the parent may be in another PID namespace
        file.write(f"{os.getppid()} {psutil.Process(os.getppid()).create_time()}")
        file.flush()
    return lock


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
