"""The two sockets of RedPitayaDAQServer: asking, uploading, receiving.  How they are connected: pairing.py.

Answers to commands of the former client may still arrive first: `*IDN?` is the mark from which on replies are ours, so
nothing else here ever asks it.
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
from drivers.red_pitaya.ports import acknowledge_at_once, said_within

MARK_S = 1.5  # time for the answer to the first *IDN?
LAST_WORD_S = 0.2  # a command that is being sent is on its way by then
UPLOAD_BYTES_PER_S = 200e3  # slower than any network the card is on
LONGEST_LINE = 4096  # bytes; the server's answers are shorter by far

Value = str | int | float


class Connection:
    """One client's pair of sockets.  Commands from any thread, samples from one."""

    def __init__(self, command: socket.socket, data: socket.socket, where: str, timeout_s: float) -> None:
        self._command, self._data, self.where, self._timeout_s = command, data, where, timeout_s
        self._lock = threading.Lock()
        self._pending = bytearray()
        self._posted: deque[str] = deque()
        self._broken: str | None = None
        self._no_data: DeviceError | None = None
        self._telling = threading.Lock()  # held while commands are sent, but not while their answers are waited for
        self._last_word = False

    @property
    def whole(self) -> bool:
        """Samples arrive, as far as is known."""
        return self._no_data is None

    def give_up_data(self, why: DeviceError) -> None:
        """Its command connection is all it has: from now on `upload` and `receive_into` raise this."""
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
            reply_kind(command)  # never send what the server would not answer
        with self._lock:
            deadline = time.monotonic() + (timeout_s or self._timeout_s)
            self._tell(commands)
            while self._posted:
                self._line(self._posted[0], deadline)
                self._posted.popleft()
            lines = [self._line(command, deadline) for command in commands]
        return [parse(command, line, self.where) for command, line in zip(commands, lines, strict=True)]

    def post(self, command: str) -> None:
        """Send a command whose answer is looked for later, by `posted`.  Raises DeviceTimeout, DeviceLost."""
        reply_kind(command)
        with self._lock:
            self._tell([command])
            self._posted.append(command)

    def posted(self) -> list[Value] | None:
        """Answers to what was posted, as far as they are here, without waiting; None: nothing is on its way.

        Whoever asks anything else meanwhile gets past them.  Raises DeviceLost, DeviceProtocolError.
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

    def call_out(self, commands: Sequence[str]) -> None:
        """Send commands that nobody waits for, in whatever state this connection is and whoever waits for answers.

        They are its last: answers would be out of step, and nobody shall undo them.
        """
        self._last_word = True
        told = self._telling.acquire(timeout=LAST_WORD_S)
        with contextlib.suppress(OSError):
            for each in commands:
                self._command.send(f"{each}\n".encode(), socket.MSG_DONTWAIT)
        if told:
            self._telling.release()

    def upload(self, command: str, payload: bytes) -> None:
        """Send a command and its bytes on the data socket.

        After a refusal the server keeps the bytes and takes them for the next upload, so the connection is unusable.
        """
        reply_kind(command)
        self._check_data()
        with self._lock:
            self._tell([command])
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
        """Let go; wakes up whoever waits for an answer or for samples.  Idempotent, any thread."""
        self._broken = self._broken or "it was closed"
        for each in (self._command, self._data):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()

    def abandon(self) -> None:
        """Wake up whoever waits, and end an upload that the server may wait for, but let it keep this client."""
        self._broken = self._broken or "it was given up"
        for link, ways in ((self._command, socket.SHUT_RD), (self._data, socket.SHUT_RDWR)):
            with contextlib.suppress(OSError):
                link.shutdown(ways)

    def answers(self, within_s: float) -> bool:
        """Whether the server still serves this client; any thread, and whoever asks at that moment is not waited for.

        False if it closes, or keeps silent for so long: this connection is of no use any more then.
        """
        until_s = time.monotonic() + within_s
        if not self._lock.acquire(timeout=within_s):
            return False
        try:
            self._check()
            self._send(self._command, b"RP:ADC:WP?\n")
            for command in (*self._posted, "RP:ADC:WP?"):
                self._line(command, until_s)
            self._posted.clear()
        except (DeviceLost, DeviceTimeout):
            return False
        finally:
            self._lock.release()
        return True

    def evicted(self) -> bool:
        """Whether the server has ended this client, or we have; any thread, also while another one reads.

        A data socket that broke alone does not tell: the server keeps the client, to the end of a recording at least.
        """
        return said_within(self._command, 0.0) == b""

    def synchronise(self, *, asked: bool = False) -> None:
        """Make sure that the next answer belongs to the next command.  Raises DeviceTimeout, DeviceLost,
        DeviceProtocolError if something else answers.

        asked: the mark was sent already, by another one on the same socket.
        """
        deadline = time.monotonic() + MARK_S
        if not asked:
            self._send(self._command, b"\n*IDN?\n")
        heard = ""
        try:
            while not heard.startswith("CUSTOM,"):
                heard = self._line("*IDN?", deadline)
                if time.monotonic() > deadline:
                    raise self._another_service(heard)
        except DeviceTimeout:
            if not heard:
                raise
            raise self._another_service(heard) from None

    def _tell(self, commands: Sequence[str]) -> None:
        with self._telling:
            self._check()
            if self._last_word:
                raise self._gone("its lines were told to go low")
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
        """The next reply line; it may arrive in several pieces.  deadline None: BlockingIOError if it is not here."""
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
            raise self._gone(self._broken)

    def _gone(self, why: str) -> DeviceLost:
        return DeviceLost(
            "there is no connection to the card",
            where=self.where,
            why=why,
            remedy="POST /stop (or start anew), which connects again with outputs off",
        )

    def _check_data(self) -> None:
        if self._no_data is not None:
            raise self._no_data

    def _another_service(self, heard: str) -> DeviceProtocolError:
        return DeviceProtocolError(
            "what answers is no RedPitayaDAQServer",
            where=self.where,
            why=f"it says {heard[:80]!r}",
            remedy="correct the address",
        )

    def lost(self, why: str) -> DeviceLost:
        """The error that says so; nothing more is asked of this connection then."""
        self._broken = self._broken or why
        return DeviceLost(
            "the card is gone",
            where=self.where,
            why=f"{why}: another client took it over, its server ended, or the network did",
            remedy="make sure that nobody else uses the card, then POST /stop, which connects again with outputs off",
        )
