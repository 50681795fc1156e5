"""The two sockets of RedPitayaDAQServer.

The server takes the command connection (5025), stops whatever its last client ran, and then waits for the data
connection (5026) without limit before it reads a command.  Whoever dies between the two leaves it half open, and every
client that connects in this order is then paired with the wrong sockets.  Connecting the data socket first heals that:
a half-open server closes it at once.  Answers to commands of the former client may still arrive: `*IDN?` is the mark
from which on replies are ours, so nothing else here ever asks it.
"""

from __future__ import annotations

import contextlib
import math
import socket
import threading
import time
from collections.abc import Sequence

from drivers.errors import DeviceError, DeviceLost, DeviceProtocolError, DeviceTimeout
from drivers.red_pitaya.commands import parse, reply_kind
from drivers.red_pitaya.ports import Unanswered, closed_within, connect, use_up_strangers

HALF_OPEN_S = 0.3  # a half-open server closes the data socket within this time
MARK_S = 1.5  # time for the answer to the first *IDN?
ATTEMPTS = 4
TAKE_OVER_S = 3.0  # no new attempt after that: somebody waits to hear that the card is gone, and will try again
UPLOAD_BYTES_PER_S = 200e3  # slower than any network the card is on

Value = str | int | float


class Connection:
    """One client's pair of sockets.  Commands from any thread, samples from one."""

    def __init__(self, command: socket.socket, data: socket.socket, where: str, timeout_s: float) -> None:
        self._command, self._data, self.where, self._timeout_s = command, data, where, timeout_s
        self.heard = False  # anything on the data socket
        self.starved = False  # a byte was waited for in vain, and there was none before: it may be a stranger's
        self._lock = threading.Lock()
        self._pending = bytearray()
        self._broken: str | None = None
        for each in (command, data):
            each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    @classmethod
    def open(
        cls, host: str, command_port: int, data_port: int, timeout_s: float, until_s: float = math.inf
    ) -> Connection:
        """Connect to a server in whatever state it is; no new attempt from `until_s` (monotonic) on, but one at least.

        Raises DeviceNotFound if nothing listens, DeviceTimeout if it does not answer, DeviceProtocolError if it is
        something else.
        """
        where = f"{host}:{command_port}"
        error: DeviceError = DeviceTimeout("the card does not answer", where=where)
        for attempt in range(ATTEMPTS):
            if attempt and time.monotonic() >= until_s:
                break
            try:
                data = connect(host, data_port)
            except Unanswered as failure:
                error = failure
                use_up_strangers(host, command_port)
                continue
            if closed_within(data, HALF_OPEN_S):
                data.close()
                continue
            connection = cls(connect(host, command_port, data), data, where, timeout_s)
            try:
                connection._synchronise()
                return connection
            except DeviceError as failure:
                error = failure
                connection.close()
        raise error

    @classmethod
    def take_over(cls, host: str, command_port: int, data_port: int, timeout_s: float) -> Connection:
        """Connect where this client is connected already: the server evicts it and zeroes all outputs at once.

        Falls back on `open`, with the same errors, but gives up after some TAKE_OVER_S.
        """
        until_s = time.monotonic() + TAKE_OVER_S
        with contextlib.suppress(DeviceError):
            command = connect(host, command_port)
            connection = cls(command, connect(host, data_port, command), f"{host}:{command_port}", timeout_s)
            try:
                connection._synchronise()
                return connection
            except DeviceError:
                connection.close()
        return cls.open(host, command_port, data_port, timeout_s, until_s)

    def ask(self, command: str) -> Value:
        """Send one command and return its answer.  Raises DeviceTimeout, DeviceLost, DeviceProtocolError."""
        return self.ask_all([command])[0]

    def ask_all(self, commands: Sequence[str], timeout_s: float | None = None) -> list[Value]:
        """Send commands one by one without waiting, then take the answers in their order; errors as in `ask`.

        timeout_s: for all of them, None: the connection's.  All answers are taken even if one is a refusal, so that
        commands and answers stay in step.
        """
        for command in commands:
            reply_kind(command)  # never send what the server would not answer
        with self._lock:
            self._check()
            deadline = time.monotonic() + (timeout_s or self._timeout_s)
            for command in commands:
                self._send(self._command, f"{command}\n".encode())
            lines = [self._line(command, deadline) for command in commands]
        return [parse(command, line, self.where) for command, line in zip(commands, lines, strict=True)]

    def upload(self, command: str, payload: bytes) -> None:
        """Send a command and its bytes on the data socket.

        After a refusal the server keeps the bytes and takes them for the next upload, so the connection is unusable.
        """
        reply_kind(command)
        with self._lock:
            self._check()
            self._send(self._command, f"{command}\n".encode())
            self._data.settimeout(self._timeout_s)
            self._send(self._data, payload)
            try:
                line = self._line(command, time.monotonic() + self._timeout_s + len(payload) / UPLOAD_BYTES_PER_S)
                parse(command, line, self.where)
            except DeviceTimeout:
                self.starved = True
                raise
            except DeviceProtocolError:
                self._broken = f"the upload {command!r} was refused"
                raise

    def receive_into(self, target: memoryview, timeout_s: float) -> None:
        """Fill `target` from the data socket.

        Raises DeviceTimeout if no byte comes for `timeout_s`, DeviceLost if the server closes.
        """
        self._data.settimeout(timeout_s)
        filled = 0
        while filled < len(target):
            try:
                count = self._data.recv_into(target[filled:])
            except TimeoutError:
                self.starved = not self.heard
                raise DeviceTimeout(
                    "no samples arrive",
                    where=self.where,
                    why=f"nothing came for {timeout_s:g} s",
                    remedy="stop the card and repeat the shot; if it happens again, check trigger, clock and network",
                ) from None
            except OSError as error:
                raise self._lost(str(error)) from None
            if count == 0:
                raise self._lost("it closed the data socket")
            self.heard = True
            filled += count

    def close(self) -> None:
        """Let go; wakes up whoever waits for an answer or for samples.  Idempotent, any thread."""
        self._broken = self._broken or "it was closed"
        for each in (self._command, self._data):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()

    def _synchronise(self) -> None:
        """Make sure that the next answer belongs to the next command."""
        deadline = time.monotonic() + MARK_S
        self._send(self._command, b"\n*IDN?\n")
        heard = ""
        try:
            while not heard.startswith("CUSTOM,"):
                heard = self._line("*IDN?", deadline)
        except DeviceTimeout:
            if not heard:
                raise
            raise DeviceProtocolError(
                "what answers is no RedPitayaDAQServer",
                where=self.where,
                why=f"to *IDN? it says {heard[:80]!r}",
                remedy="correct the address",
            ) from None

    def _send(self, to: socket.socket, data: bytes) -> None:
        """One send: the server executes half a command when the other half comes late."""
        try:
            to.sendall(data)
        except TimeoutError:
            self._broken = "sending did not end"
            raise DeviceTimeout("the card takes no data", where=self.where, remedy="check the network") from None
        except OSError as error:
            raise self._lost(str(error)) from None

    def _line(self, command: str, deadline: float) -> str:
        """The next reply line; it may arrive in several pieces."""
        while (end := self._pending.find(b"\n")) < 0:
            try:
                self._command.settimeout(max(deadline - time.monotonic(), 1e-3))
                piece = self._command.recv(4096)
            except TimeoutError:
                self._broken = f"{command!r} was not answered"
                raise DeviceTimeout(
                    f"no answer to {command!r}", where=self.where, remedy="check network, card and server version"
                ) from None
            except OSError as error:
                raise self._lost(str(error)) from None
            if not piece:
                raise self._lost("it closed the command socket")
            self._pending += piece
        line = self._pending[:end].decode("ascii", "replace").rstrip("\r")
        del self._pending[: end + 1]
        return line

    def _check(self) -> None:
        if self._broken is not None:
            raise DeviceLost(
                "there is no connection to the card",
                where=self.where,
                why=self._broken,
                remedy="POST /stop (or start anew), which connects again with outputs off",
            )

    def _lost(self, why: str) -> DeviceLost:
        self._broken = self._broken or why
        return DeviceLost(
            "the card is gone",
            where=self.where,
            why=f"{why}: another client took it over, its server ended, or the network did",
            remedy="make sure that nobody else uses the card, then POST /stop, which connects again with outputs off",
        )
