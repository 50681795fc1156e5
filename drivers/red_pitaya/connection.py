"""The two sockets of RedPitayaDAQServer: asking, uploading, receiving.  pairing.py connects them.

Answers to commands of the former client may arrive first.  The answer to `*IDN?` is the mark after which all replies
belong to this client, so `*IDN?` is sent for nothing else.
"""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections import deque
from collections.abc import Sequence

from drivers.errors import DeviceError, DeviceLost, DeviceProtocolError, DeviceTimeout
from drivers.red_pitaya.commands import parse, reply_kind
from drivers.red_pitaya.ports import acknowledge_at_once, peek

MARK_S = 1.5  # time for the answer to the first *IDN?
FINAL_S = 0.2  # a command that another thread is sending has been sent by then
UPLOAD_BYTES_PER_S = 200e3  # slower than any network the card is on
LONGEST_LINE = 4096  # bytes; the server's answers are shorter by far

Value = str | int | float


class Connection:
    """One client's pair of sockets.  Commands from any thread, samples from one."""

    def __init__(self, command: socket.socket, data: socket.socket, where: str, timeout_s: float) -> None:
        self._command = command
        self._data = data
        self.where = where
        self._timeout_s = timeout_s
        self._lock = threading.Lock()
        self._pending = bytearray()
        self._posted: deque[str] = deque()
        self._broken: str | None = None
        self._no_data: DeviceError | None = None
        self._send_lock = threading.Lock()  # held while commands are sent, but not while waiting for their answers
        self._final_sent = False

    @property
    def whole(self) -> bool:
        """Whether samples arrive, as far as is known."""
        return self._no_data is None

    def give_up_data(self, why: DeviceError) -> None:
        """Use the command connection alone: from now on `upload` and `receive_into` raise this error."""
        self._no_data = why

    def ask(self, command: str) -> Value:
        """Send one command and return its answer.  Raises DeviceTimeout, DeviceLost, DeviceProtocolError."""
        return self.ask_all([command])[0]

    def ask_all(self, commands: Sequence[str], timeout_s: float | None = None) -> list[Value]:
        """Send commands one by one without waiting, then take the answers in their order; errors as in `ask`.

        timeout_s: for all of them, None: the connection's.  All answers are taken even if one is a refusal, so that
        commands and answers stay in step.
        """
        for command in commands:
            reply_kind(command)  # a command without a known reply is never sent
        with self._lock:
            deadline = time.monotonic() + (timeout_s or self._timeout_s)
            self._transmit(commands)
            while self._posted:
                self._line(self._posted[0], deadline)
                self._posted.popleft()
            lines = [self._line(command, deadline) for command in commands]
        return [parse(command, line, self.where) for command, line in zip(commands, lines, strict=True)]

    def post(self, command: str) -> None:
        """Send a command whose answer `posted` returns later.  Raises DeviceTimeout, DeviceLost."""
        reply_kind(command)
        with self._lock:
            self._transmit([command])
            self._posted.append(command)

    def posted(self) -> list[Value] | None:
        """Answers to posted commands, as far as they have arrived, without waiting; None: no answer is outstanding.

        A question that another thread asks meanwhile discards them.  Raises DeviceLost, DeviceProtocolError.
        """
        found: list[Value] = []
        with self._lock:
            self._check()
            if not self._posted:
                return None
            with contextlib.suppress(BlockingIOError):
                while self._posted:
                    line = self._line(self._posted[0], None)
                    found.append(parse(self._posted.popleft(), line, self.where))
        return found

    def send_final(self, commands: Sequence[str]) -> None:
        """Send commands without waiting for answers, in any state of this connection, also while another thread waits.

        They are the last on this connection: later answers would be out of step, and no later command may undo them.
        """
        self._final_sent = True
        acquired = self._send_lock.acquire(timeout=FINAL_S)
        with contextlib.suppress(OSError):
            for each in commands:
                self._command.send(f"{each}\n".encode(), socket.MSG_DONTWAIT)
        if acquired:
            self._send_lock.release()

    def upload(self, command: str, payload: bytes) -> None:
        """Send a command and its bytes on the data socket.

        After a refusal the server keeps the bytes and takes them for the next upload, so the connection is unusable.
        """
        reply_kind(command)
        self._check_data()
        with self._lock:
            self._transmit([command])
            self._data.settimeout(self._timeout_s)
            self._send(self._data, payload)
            try:
                line = self._line(command, time.monotonic() + self._timeout_s + len(payload) / UPLOAD_BYTES_PER_S)
                parse(command, line, self.where)
            except DeviceProtocolError:
                self._broken = f"the upload {command!r} was refused"
                raise

    def receive_into(self, target: memoryview, timeout_s: float) -> None:
        """Fill `target` from the data socket.

        Raises DeviceTimeout if no byte comes for `timeout_s`, DeviceLost if the server closes.
        """
        self._check_data()
        filled = 0
        while filled < len(target):
            try:
                self._data.settimeout(timeout_s)
                acknowledge_at_once(self._data)
                count = self._data.recv_into(target[filled:])
            except TimeoutError:
                raise DeviceTimeout(
                    "no samples arrive",
                    where=self.where,
                    why=f"nothing came for {timeout_s:g} s",
                    remedy="stop the card and repeat the shot; if it happens again, check trigger, clock and network",
                ) from None
            except OSError as error:
                raise self.lost(str(error)) from None
            if count == 0:
                raise self.lost("it closed the data socket")
            filled += count

    def close(self) -> None:
        """Close both sockets, which wakes up threads that wait for answers or samples.  Idempotent; any thread."""
        self._broken = self._broken or "it was closed"
        for each in (self._command, self._data):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()

    def abandon(self) -> None:
        """Wake up waiting threads, and end an upload that the server may wait for, but let it keep this client."""
        self._broken = self._broken or "it was given up"
        for link, ways in ((self._command, socket.SHUT_RD), (self._data, socket.SHUT_RDWR)):
            with contextlib.suppress(OSError):
                link.shutdown(ways)

    def answers(self, within_s: float) -> bool:
        """Whether the server still serves this client.  Any thread; does not wait for a thread that is asking.

        False if the server closes, or does not answer within that time: the connection is then unusable.
        """
        deadline_s = time.monotonic() + within_s
        if not self._lock.acquire(timeout=within_s):
            return False
        try:
            self._check()
            self._send(self._command, b"RP:ADC:WP?\n")
            for command in (*self._posted, "RP:ADC:WP?"):
                self._line(command, deadline_s)
            self._posted.clear()
        except (DeviceLost, DeviceTimeout):
            return False
        finally:
            self._lock.release()
        return True

    def evicted(self) -> bool:
        """Whether the server or this side has ended the connection; any thread, also while another one reads.

        A broken data socket alone is no proof: the server keeps the client, at least to the end of a recording.
        """
        return peek(self._command, 0.0) == b""

    def synchronise(self, *, mark_sent: bool = False) -> None:
        """Make sure that the next answer belongs to the next command.  Raises DeviceTimeout, DeviceLost,
        DeviceProtocolError if something else answers.

        mark_sent: `*IDN?` was sent already, by another object on the same socket.
        """
        deadline = time.monotonic() + MARK_S
        if not mark_sent:
            self._send(self._command, b"\n*IDN?\n")
        line = ""
        try:
            while not line.startswith("CUSTOM,"):
                line = self._line("*IDN?", deadline)
                if time.monotonic() > deadline:
                    raise self._another_service(line)
        except DeviceTimeout:
            if not line:
                raise
            raise self._another_service(line) from None

    def _transmit(self, commands: Sequence[str]) -> None:
        with self._send_lock:
            self._check()
            if self._final_sent:
                raise self._unusable("its lines were set low")
            for command in commands:
                self._send(self._command, f"{command}\n".encode())

    def _send(self, to: socket.socket, data: bytes) -> None:
        """One send: the server executes half a command when the other half comes late."""
        try:
            to.sendall(data)
        except TimeoutError:
            self._broken = "sending did not end"
            raise DeviceTimeout("the card takes no data", where=self.where, remedy="check the network") from None
        except OSError as error:
            raise self.lost(str(error)) from None

    def _line(self, command: str, deadline: float | None) -> str:
        """The next reply line, which may arrive in pieces.  deadline None: BlockingIOError if it has not arrived."""
        while (end := self._pending.find(b"\n")) < 0:
            try:
                self._command.settimeout(0.0 if deadline is None else max(deadline - time.monotonic(), 1e-3))
                acknowledge_at_once(self._command)
                piece = self._command.recv(4096)
            except BlockingIOError:
                raise
            except TimeoutError:
                self._broken = f"{command!r} was not answered"
                raise DeviceTimeout(
                    f"no answer to {command!r}", where=self.where, remedy="check network, card and server version"
                ) from None
            except OSError as error:
                raise self.lost(str(error)) from None
            if not piece:
                raise self.lost("it closed the command socket")
            self._pending += piece
            if len(self._pending) > LONGEST_LINE and b"\n" not in self._pending:
                self._broken = "what it says has no end"
                raise self._another_service(self._pending[:80].decode("ascii", "replace"))
        line = self._pending[:end].decode("ascii", "replace").rstrip("\r")
        del self._pending[: end + 1]
        return line

    def _check(self) -> None:
        if self._broken is not None:
            raise self._unusable(self._broken)

    def _unusable(self, why: str) -> DeviceLost:
        return DeviceLost(
            "there is no connection to the card",
            where=self.where,
            why=why,
            remedy="POST /stop (or restart the daemon), which connects again with outputs off",
        )

    def _check_data(self) -> None:
        if self._no_data is not None:
            raise self._no_data

    def _another_service(self, line: str) -> DeviceProtocolError:
        return DeviceProtocolError(
            "what answers is no RedPitayaDAQServer",
            where=self.where,
            why=f"it says {line[:80]!r}",
            remedy="correct the address",
        )

    def lost(self, why: str) -> DeviceLost:
        """Mark the connection as broken, and return the error that says so."""
        self._broken = self._broken or why
        return DeviceLost(
            "the card is gone",
            where=self.where,
            why=f"{why}: another client took it over, its server ended, or the network did",
            remedy="end other programs that use the card, then POST /stop, which connects again with outputs off",
        )
