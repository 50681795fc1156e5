"""Where the local socket is: in the data folder, however long its path.

The address of a local socket holds 107 bytes.  The folder is opened, and the address goes by way of that.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path

NAME = "hardware.sock"


def through_folder(path: Path, use: Callable[[str], None]) -> None:
    """Call `use` with a short address of the socket `path`.  Raises OSError."""
    folder = os.open(path.parent, os.O_PATH | os.O_DIRECTORY)
    try:
        use(f"/proc/self/fd/{folder}/{path.name}")
    finally:
        os.close(folder)


def connected(path: Path, timeout_s: float | None) -> socket.socket:
    """A connection to whoever listens there.  Raises OSError."""
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        connection.settimeout(timeout_s)
        through_folder(path, connection.connect)
    except BaseException:
        connection.close()
        raise
    return connection


def listening(path: Path) -> socket.socket:
    """A socket that only this user can connect to; one that a dead process has left behind is replaced.

    Raises OSError.
    """
    path.unlink(missing_ok=True)
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    before = os.umask(0o177)
    try:
        through_folder(path, listener.bind)
    except BaseException:
        listener.close()
        raise
    finally:
        os.umask(before)
    listener.listen(128)
    return listener
