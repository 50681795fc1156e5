"""One daemon per card on this computer: the server lets every newcomer throw out whoever is connected.

The file also keeps when a recording will be over, for who comes after a daemon that died in it.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import socket
import tempfile
from pathlib import Path
from typing import TextIO

from drivers.errors import DeviceDenied


def lock_card(host: str, port: int) -> TextIO:
    """Hold the card at this address, by whatever name, until the file returned is closed or the process ends.

    Raises DeviceDenied if another process holds it.
    """
    name = f"{_address(host)}-{port}".replace(os.sep, "_")
    path = Path(tempfile.gettempdir()) / f"platform-daemon-io-card-{name}.lock"
    try:
        file = path.open("a+")
    except PermissionError:
        raise _in_use(host, port, f"{path} belongs to another user") from None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise _in_use(host, port, f"another process holds {path}") from None
    return file


def note_recording(lock: TextIO, until_s: float) -> None:
    """The server sends samples until then (monotonic time of this computer), whatever becomes of this process."""
    with contextlib.suppress(OSError):  # a full disk must cost no shot; nor may a buffer of Python's fail later
        os.ftruncate(lock.fileno(), 0)
        os.write(lock.fileno(), f"{until_s:.3f}".encode())


def recording_until(lock: TextIO) -> float:
    """What the daemon before has noted; far in the past if it has not, or in another boot of the computer, maybe."""
    lock.seek(0)
    try:
        return float(lock.read(40))
    except ValueError:
        return float("-inf")


def _address(host: str) -> str:
    """The numbers behind a name; the name itself if nobody knows it, which connecting will say."""
    try:
        return socket.gethostbyname(host)
    except OSError:
        return host


def _in_use(host: str, port: int, why: str) -> DeviceDenied:
    return DeviceDenied(
        "another daemon on this computer uses the card",
        where=f"{host}:{port}",
        why=why,
        remedy="stop it: a second connection would throw it out in the middle of a shot",
    )
