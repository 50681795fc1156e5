"""Scripted devices for tests of drivers: the driver is the real one, only the device is a function.  It is published,
as the suites of `drivers.conformance` are.

A *device* is a function of one line (text without its end).  It gives the line that it answers, or None if it does
not answer.  On a scripted wire it may give a DeviceError, which the wire then raises; behind a real port it may give
bytes, which go over it as they are (garbage, half an answer).

    lamp = {"*IDN?": "ACME,lamp,7,1.2", "LIT?": "0"}.get
    wires = ScriptedWires(lamp)
    exchange = Exchange("lamp", wires)              # opens a ScriptedWire; no port, no socket, no thread
    wires.device = lambda line: None                # from now on it is silent: DeviceTimeout
    assert wires.opened[0].closed                   # after a failure the exchange has closed the wire

ScriptedWires, ScriptedWire: the place of a wire, for drivers above `drivers.exchange`.
TcpDevice, SerialDevice: the same functions behind a real TCP port or pseudo-terminal, for wires themselves.
"""

from __future__ import annotations

import os
import select
import socket
import threading
import tty
from collections.abc import Callable, Iterable
from types import TracebackType
from typing import Self

from drivers.errors import DeviceError, DeviceTimeout

Answer = str | DeviceError | None
Device = Callable[[str], Answer]
RawDevice = Callable[[str], str | bytes | None]

POLL_S = 0.01


class ScriptedWire:
    """See drivers.exchange.Wire; what is sent goes to a device, what it answers is received in order.

    Receiving when there is no answer is a time-out at once.  `late`: lines that arrive before the first answer, as
    after a time-out.  `sent`: every line so far; `closed`: whether it was closed.
    """

    def __init__(self, device: Device, late: Iterable[str] = ()) -> None:
        self._device = device
        self._answers: list[str | DeviceError] = list(late)
        self.sent: list[str] = []
        self.closed = False

    def send(self, text: str) -> None:
        """See Wire."""
        self.sent.append(text)
        answer = self._device(text)
        if answer is not None:
            self._answers.append(answer)

    def receive(self) -> str:
        """See Wire.  Raises DeviceTimeout if there is no answer, or the error that the device gave as one."""
        if not self._answers:
            raise DeviceTimeout("no answer", where="scripted wire", why="the device says nothing")
        answer = self._answers.pop(0)
        if isinstance(answer, DeviceError):
            raise answer
        return answer

    def close(self) -> None:
        """See Wire."""
        self.closed = True


class ScriptedWires:
    """Opens a new wire to the same device each time it is called: the `open_wire` of drivers.exchange.Exchange.

    `device` may be replaced at any time, wires that are open get the new one too; `late`: lines that arrive first on
    the wire that is opened next, and only there; `opened`: all wires so far.
    """

    def __init__(self, device: Device) -> None:
        self.device = device
        self.late: list[str] = []
        self.opened: list[ScriptedWire] = []

    def __call__(self) -> ScriptedWire:
        """A new wire."""
        self.opened.append(ScriptedWire(self._answer, self.late))
        self.late = []
        return self.opened[-1]

    def _answer(self, line: str) -> Answer:
        return self.device(line)


class TcpDevice:
    """A device behind a TCP port of this computer; one connection after the other.  Close it, or use it in `with`.

    `end` ends its lines in both directions; `heard`: every line so far with its end, as it came.
    """

    def __init__(self, device: RawDevice, end: str = "\n") -> None:
        self._device = device
        self._end = end.encode("ascii")
        self.heard: list[bytes] = []
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listening.getsockname()[1]
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop listening and hang up.  Idempotent."""
        self._over.set()
        self._thread.join()
        self._listening.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _serve(self) -> None:
        while not self._over.is_set():
            if _readable(self._listening.fileno()):
                with self._listening.accept()[0] as peer:
                    self._talk(peer)

    def _talk(self, peer: socket.socket) -> None:
        """Until one of the two goes."""
        pending = b""
        try:
            while not self._over.is_set():
                if not _readable(peer.fileno()):
                    continue
                if not (more := peer.recv(4096)):
                    return
                *lines, pending = (pending + more).split(self._end)
                for line in lines:
                    self.heard.append(line + self._end)
                    peer.sendall(_raw(self._device(line.decode("ascii").strip()), self._end))
        except OSError:
            return  # the other side has closed the connection


class SerialDevice:
    """A device on a pseudo-terminal: `port` is what a driver opens.  Its lines end with LF, its answers with CR LF.

    Close it, or use it in `with`.
    """

    def __init__(self, device: RawDevice) -> None:
        self._device = device
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Take the port away.  Idempotent."""
        if self._over.is_set():
            return
        self._over.set()
        self._thread.join()  # first: it would answer for the next terminal that gets the same number
        os.close(self._master)
        os.close(self._slave)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _serve(self) -> None:
        pending = b""
        while not self._over.is_set():
            if not _readable(self._master):
                continue
            *lines, pending = (pending + os.read(self._master, 1000)).split(b"\n")
            for line in lines:
                os.write(self._master, _raw(self._device(line.decode("ascii").strip()), b"\r\n"))


def _readable(descriptor: int) -> bool:
    """Whether something arrives there within POLL_S."""
    return bool(select.select([descriptor], [], [], POLL_S)[0])


def _raw(answer: str | bytes | None, end: bytes) -> bytes:
    """An answer as it goes over a wire."""
    if answer is None:
        return b""
    return answer if isinstance(answer, bytes) else answer.encode("ascii") + end
