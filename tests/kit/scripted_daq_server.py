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


PROOF = (b"RP:MODE ACQUISITION\nRP:ADC:DATA? 0,16\n", b"1\r\n1\r\n", b"\0" * 64)


def prove(command: socket.socket, data: socket.socket) -> None:
    """Take and answer what a client asks to see that both sockets are its own."""
    heard = b""
    while len(heard) < len(PROOF[0]):
        heard += command.recv(len(PROOF[0]) - len(heard))
    assert heard == PROOF[0]
    command.sendall(PROOF[1])
    data.sendall(PROOF[2])


def answering(replies: dict[str, str]) -> Script:
    """Answers from a table, silence to everything else, until the client goes."""

    def script(command: socket.socket, data: socket.socket) -> None:
        stream = command.makefile("r")
        for line in stream:
            asked = line.strip()
            known = {"*IDN?": "CUSTOM,REDPITAYA,0,0.1", "RP:MODE ACQUISITION": "1", "RP:ADC:DATA? 0,16": "1"}
            reply = (known | replies).get(asked)
            if reply is not None:
                command.sendall(f"{reply}\r\n".encode())
            if asked == "RP:ADC:DATA? 0,16":
                data.sendall(PROOF[2])

    return script
