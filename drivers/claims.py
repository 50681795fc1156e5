"""Claims: at most one process of this computer holds a name, whatever its account and its file system.

A claim is a listening socket in Linux's abstract name space.  The kernel releases it with the last process that holds
it, so nothing is left behind that could be taken for somebody's presence, and nothing must be writable.  It is seen
from every account and mount namespace: a service with a `/tmp` and a home of its own (`PrivateTmp=`, `ProtectHome=`,
`ProtectSystem=`) and a person in a terminal meet there.  Its scope is the network namespace, as that of the connections
to the devices.

The holder answers every connection with its record, some bytes that say which process it is.
"""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import struct
import threading
import time
from dataclasses import dataclass

_PREFIX = "\0platform-daemon/"
_ANSWER_S = 1.0  # for some bytes of a process that lives; a halted one says nothing
_AGAIN_S = 0.1
_RECORD_BYTES = 8192
_CREDENTIALS = struct.Struct("3i")  # of SO_PEERCRED: process, account, group


class Claimed(Exception):
    """Another process holds the name."""


@dataclass(frozen=True)
class Holder:
    """A process that holds a name.

    pid: of the process that claimed it, which a child that inherited the claim may have outlived; account: its user id;
    record: what it says of itself, None if it does not answer.
    """

    pid: int
    account: int
    record: bytes | None


class Claim:
    """A claim of this process.  Children hold it too if they inherit `fd`; a forked one lets it go by `forget`."""

    def __init__(self, name: str, record: bytes = b"") -> None:
        """Claim `name`, at most 80 characters.  Raises Claimed if another process holds it, OSError."""
        self.record = record
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._socket.bind(_PREFIX + name)
        except OSError as error:
            self._socket.close()
            if error.errno == errno.EADDRINUSE:
                raise Claimed(name) from None
            raise
        self._socket.listen(16)
        self._thread = threading.Thread(target=self._answer, name="claim", daemon=True)
        self._thread.start()

    @property
    def fd(self) -> int:
        """The descriptor that a child must inherit to hold the claim as well; -1 once it has been released."""
        return self._socket.fileno()

    def close(self) -> None:
        """Release the claim.  Idempotent."""
        with contextlib.suppress(OSError):  # ends the wait of the other thread, which would hold the name
            self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join(2 * _ANSWER_S)
        self._socket.close()

    def forget(self) -> None:
        """Close this process's descriptor and leave the claim to the process from which it was inherited."""
        self._socket.close()

    def _answer(self) -> None:
        while True:
            try:
                connection, _ = self._socket.accept()
            except OSError as error:
                if error.errno in (errno.EINVAL, errno.EBADF):  # released
                    return
                time.sleep(_AGAIN_S)  # for want of descriptors
                continue
            with connection, contextlib.suppress(OSError):
                connection.settimeout(_ANSWER_S)
                connection.sendall(self.record)


def holder_of(name: str) -> Holder | None:
    """The process that holds the name; None: no process does.  Raises OSError."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
        connection.settimeout(_ANSWER_S)
        try:
            connection.connect(_PREFIX + name)
        except ConnectionRefusedError:
            return None
        except (BlockingIOError, TimeoutError):  # its queue is full: it answers no connection
            return Holder(0, -1, None)
        pid, account, _ = _CREDENTIALS.unpack(
            connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
        )
        return Holder(pid, account, _record(connection) if _runs(pid) else None)


def _record(connection: socket.socket) -> bytes | None:
    """What the holder sends before it hangs up; None if it does not answer."""
    received = b""
    try:
        while len(received) < _RECORD_BYTES and (piece := connection.recv(_RECORD_BYTES)):
            received += piece
    except OSError:
        return None
    return received or None


def _runs(pid: int) -> bool:
    """Whether a process of that number runs; True for one of another PID namespace, whose number is 0."""
    return pid == 0 or os.path.exists(f"/proc/{pid}")
