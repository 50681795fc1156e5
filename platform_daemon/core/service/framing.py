"""One end of a connection over the local socket: a line of JSON for a call, one for its answer."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import struct

from drivers.errors import DeviceProtocolError
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.rpc import RpcAnswer, RpcCall

LONGEST = 256 * 1024 * 1024
"""Bytes of a line: a job with the fits of some ten thousand shots; a longer line is refused."""
ALIVE = "alive"
"""Method of a call that only checks whether the process answers."""


class JsonLineConnection:
    """One end of a connection.  Not for several threads at once."""

    def __init__(self, connection: socket.socket) -> None:
        self._socket = connection
        self._file = connection.makefile("rb")

    def send(self, message: RpcCall | RpcAnswer) -> None:
        """Raises OSError."""
        self._socket.sendall(to_json(message, allow_nan=True).encode() + b"\n")

    def call(self) -> RpcCall | None:
        """The next call; None: the other end has closed the connection.  Raises OSError, DeviceProtocolError."""
        line = self._line()
        return None if line is None else RpcCall.model_validate_json(line)

    def answer(self) -> RpcAnswer | None:
        """The answer to the call; None: the other end has closed.  Raises OSError, DeviceProtocolError."""
        line = self._line()
        return None if line is None else RpcAnswer.model_validate_json(line)

    def is_stale(self) -> bool:
        """Whether the other end has closed the connection, or has sent something without a call."""
        return self.has_said(0)

    def has_said(self, within_s: float) -> bool:
        """Whether the other end sends something, or closes, within so many seconds; call it before anything is read."""
        return bool(select.select([self._socket], [], [], within_s)[0])

    def peer(self) -> int | None:
        """A pidfd of the process that listens at the other end, which the caller closes; None: it has ended.

        For the end that has connected.  If another process has taken the process id meanwhile, this connection has
        been closed, which is noticed before a time-out.
        """
        pid, _, _ = struct.unpack("3i", self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12))
        try:
            return os.pidfd_open(pid)
        except OSError:
            return None

    def close(self) -> None:
        """Idempotent."""
        with contextlib.suppress(OSError):
            self._file.close()
        self._socket.close()

    def _line(self) -> bytes | None:
        line = self._file.readline(LONGEST)
        if line and not line.endswith(b"\n") and len(line) >= LONGEST:
            raise DeviceProtocolError("a message is too long", where="hardware.sock")
        return line if line.endswith(b"\n") else None
