"""One end of a connection over the local socket: a line of JSON for a call, one for its answer."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import struct

from drivers.errors import DeviceProtocolError
from platform_daemon.schemas import LinkAnswer, LinkCall, to_json

LONGEST = 256 * 1024 * 1024
"""Bytes of a line: a job with the fits of some ten thousand shots; whatever is longer is no message of ours."""
ALIVE = "alive"
"""What is asked only to see whether somebody answers; nothing is looked at for it."""


class Line:
    """One end of a connection.  Not for several threads at once."""

    def __init__(self, connection: socket.socket) -> None:
        self._socket = connection
        self._file = connection.makefile("rb")

    def send(self, message: LinkCall | LinkAnswer) -> None:
        """Raises OSError."""
        self._socket.sendall(to_json(message, allow_nan=True).encode() + b"\n")

    def call(self) -> LinkCall | None:
        """The next call; None: the other end has gone.  Raises OSError, DeviceProtocolError."""
        line = self._line()
        return None if line is None else LinkCall.model_validate_json(line)

    def answer(self) -> LinkAnswer | None:
        """The answer to what was sent; None: the other end has gone.  Raises OSError, DeviceProtocolError."""
        line = self._line()
        return None if line is None else LinkAnswer.model_validate_json(line)

    def is_stale(self) -> bool:
        """Has the other end gone, or said what nobody asked?"""
        return self.has_said(0)

    def has_said(self, within_s: float) -> bool:
        """Does the other end say something, or go, within so many seconds?  For a line that nothing was read from."""
        return bool(select.select([self._socket], [], [], within_s)[0])

    def peer(self) -> int | None:
        """A pidfd of the process that listens at the other end, which the caller closes; None: it has gone.

        For one that has connected.  A number that another process has got meanwhile does no harm: then this line has
        been closed, and says so before it is silent.
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
