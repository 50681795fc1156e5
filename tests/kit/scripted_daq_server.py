"""A server that behaves as a test tells it: two listening sockets and a script."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Callable

Script = Callable[[socket.socket, socket.socket], None]


def listener() -> socket.socket:
    made = socket.socket()
    made.bind(("127.0.0.1", 0))
    made.listen(1)
    return made


class ScriptedDaqServer:
    """Accepts a command and a data connection, in this order, for every script given, and runs it with both."""

    def __init__(self, *scripts: Script) -> None:
        self._command, self._data = listener(), listener()
        self._open: list[socket.socket] = [self._command, self._data]
        self._scripts = scripts
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    @property
    def ports(self) -> tuple[int, int]:
        return self._command.getsockname()[1], self._data.getsockname()[1]

    def close(self) -> None:
        for each in self._open:
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)  # closing alone does not wake up accept()
            each.close()
        self._thread.join(5)

    def _serve(self) -> None:
        try:
            for script in self._scripts:
                command, _ = self._command.accept()
                data, _ = self._data.accept()
                self._open += [command, data]
                script(command, data)
        except OSError:
            pass  # closed by the test


def lines(command: socket.socket) -> Callable[[], str]:
    """The next non-empty line that the client sends."""
    stream = command.makefile("r")

    def following() -> str:
        while not (line := stream.readline().strip()):
            pass
        return line

    return following


def answering(replies: dict[str, str]) -> Script:
    """Answers from a table, silence to everything else, until the client goes."""

    def script(command: socket.socket, data: socket.socket) -> None:
        stream = command.makefile("r")
        for line in stream:
            reply = {"*IDN?": "CUSTOM,REDPITAYA,0,0.1", **replies}.get(line.strip())
            if reply is not None:
                command.sendall(f"{reply}\r\n".encode())

    return script
