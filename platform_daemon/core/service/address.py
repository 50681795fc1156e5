"""Where the local socket is: in the data folder, however long its path.

The address of a local socket holds 107 bytes.  The folder is opened, and the address goes by way of that.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path

NAME = "hardware.sock"


def folder_of(path: Path) -> int:
    """A descriptor of the folder of a socket, which stays its folder wherever that is moved.  Raises OSError."""
    return os.open(path.parent, os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC)


def through_folder(path: Path, use: Callable[[str], None]) -> None:
    """Call `use` with a short address of the socket `path`.  Raises OSError."""
    folder = folder_of(path)
    try:
        use(_address(folder, path))
    finally:
        os.close(folder)


def connected(path: Path, timeout_s: float | None, folder: int | None = None) -> socket.socket:
    """A connection to the process that listens there; folder: of the path as it was opened, see `folder_of`.

    Raises OSError.
    """
    connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        connection.settimeout(timeout_s)
        if folder is None:
            through_folder(path, connection.connect)
        else:
            connection.connect(_address(folder, path))
    except BaseException:
        connection.close()
        raise
    return connection


def _address(folder: int, path: Path) -> str:
    return f"/proc/self/fd/{folder}/{path.name}"


def listening(path: Path, *, replace: bool = True) -> socket.socket:
    """A socket that only this user can connect to; replace: one that a dead process has left behind goes.

    Raises OSError.
    """
    if replace:
        path.unlink(missing_ok=True)
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    try:
        os.fchmod(listener.fileno(), 0o600)  # what is bound gets it; a umask would be that of all threads meanwhile
        through_folder(path, listener.bind)
    except BaseException:
        listener.close()
        raise
    listener.listen(128)
    return listener
