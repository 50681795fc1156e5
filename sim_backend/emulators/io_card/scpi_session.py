"""One client of the I/O card's server: a thread that reads commands, answers them and sends samples in between.

The server looks at its command socket every millisecond, takes 32 bytes at a time, and whenever nothing is waiting it
executes what its buffer holds as if it were complete.
"""

from __future__ import annotations

import select
import socket
import struct
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import nullcontext, suppress

from ..listening import hang_up
from ..scpi import CommandTable, split
from ..wire_faults import Hangup, WireFaults
from .board import Board, Mode
from .daq_acquisition import ACQUISITION
from .daq_calibration import CALIBRATION
from .daq_handler import Code, Handler, Silence
from .daq_misc import SERVER
from .daq_sequence import SEQUENCE, UPLOADS, set_sequence
from .daq_waveforms import WAVEFORMS, set_table
from .sending import Sending
from .sequence import ServerCrash

POLL_S = 1e-3
BITE = 32
BUSY_STEP_S = 0.05  # after so long at most it notices that the process ends
ERRORS = 17
COMMANDS: CommandTable[Handler] = CommandTable(SERVER | WAVEFORMS | SEQUENCE | ACQUISITION | CALIBRATION)
WAITING = frozenset({set_table, set_sequence, *UPLOADS})
"""Handlers that wait for bytes or take their time.  They take the world's lock themselves if they need it; all others
run with it held."""
LOG = b"RedPitayaDAQServer, emulated\n"


class ScpiSession:
    """Serves a client until it goes, is evicted, or the server dies."""

    def __init__(
        self,
        board: Board,
        command: socket.socket,
        data: socket.socket,
        faults: WireFaults,
        crash: Callable[[], None],
        left_over: bytes,
    ) -> None:
        self.board = board
        self._command = command
        self._data = data
        self._faults = faults
        self._crash = crash
        self._replies = command
        self._buffer = left_over
        self.errors: deque[str] = deque(maxlen=ERRORS)
        self._sending: Sending | None = None
        self._dying = False
        self.gone_s: float | None = None
        self._evicted = threading.Event()
        self._wake, self._woken = socket.socketpair()
        self._thread = threading.Thread(target=self._run, name="daq-client", daemon=True)
        self._thread.start()

    def end(self, successor: socket.socket | None = None) -> bytes:
        """Stop serving; replies still to come go to `successor`.  Returns what the parser's buffer holds."""
        self._replies = successor or self._command
        self._dying |= successor is None  # first: a client that is ended in order switches everything off
        self._evicted.set()
        with suppress(OSError):
            self._wake.send(b"x")
        while threading.current_thread() is not self._thread and self._thread.is_alive():
            self._thread.join(timeout=5)
            if successor is None:
                break
        return self._buffer

    def die(self) -> None:
        """The process ends, in the middle of whatever it does."""
        self._dying = True

    # --- what handlers need

    def upload(self, count: int) -> bytes:
        """See daq_handler.Connection.  The server waits for them, and serves no other client meanwhile."""
        parts: list[bytes] = []
        while count > 0 and not self._dying:
            if _readable([self._data], 0.05):
                part = self._data.recv(min(count, 1 << 16))
                if not part:
                    break
                parts.append(part)
                count -= len(part)
        return b"".join(parts)

    def busy(self, seconds: float) -> None:
        """See daq_handler.Connection.  A client that takes over waits for the end of it."""
        clock = self.board.cards.world.clock
        until_s = clock.monotonic_s() + seconds
        while not self._dying and (left_s := until_s - clock.monotonic_s()) > 0:
            clock.sleep(min(left_s, BUSY_STEP_S))

    def start_sending(self, start: int, count: int, chunk: int | None) -> None:
        """See daq_handler.Connection."""
        self.board.reading(start, count)
        if chunk is None:
            self._later = lambda: self._write(self.board.samples(start, start + count))
        else:
            self.board.mode = Mode.TRANSMISSION
            self._sending = Sending(self.board, start, count, chunk, self._write)

    def stop_sending(self) -> bool:
        """See daq_handler.Connection."""
        sending = self._sending
        self._finish()
        return sending is not None

    def send_log(self) -> None:
        """See daq_handler.Connection."""
        self._later = lambda: self._write(struct.pack("<q", len(LOG)) + LOG)

    def send_performance(self) -> None:
        """See daq_handler.Connection."""
        if (sending := self._sending) is not None:
            self._later = lambda: self._write(sending.performance)

    # --- the thread

    def _run(self) -> None:
        try:
            while not self._evicted.is_set():
                if self._sending is None:
                    self._commands(None)
                else:
                    self._sending.chunk(self._evicted)
                    if self._sending is not None and self._sending.over():
                        self._finish()
                    self._commands(0.0)
            if not self._dying:
                self._last_words()
        except (OSError, EOFError):
            self.gone_s = time.monotonic()
        except Hangup as fault:
            with suppress(OSError):
                self._replies.send(fault.last)
        except ServerCrash:
            self._dying = True
            self._crash()
        finally:
            self._leave()

    def _leave(self) -> None:
        """As the server ends a client: outputs to zero, connections closed."""
        for link in (self._command, self._data, self._wake, self._woken):
            hang_up(link)
        if self._dying:
            return  # no process is left that could switch anything off
        with self.board.cards.world.lock:
            self.board.client_changed()

    def _last_words(self) -> None:
        """Answer what the evicted client had already sent."""
        self._command.setblocking(False)
        with suppress(BlockingIOError):
            while part := self._command.recv(1 << 16):
                self._buffer += part
        while b"\n" in self._buffer:
            self._execute_line()

    def _commands(self, timeout_s: float | None) -> None:
        """Execute what waits on the command socket; None: wait until something comes.  Raises EOFError if the client
        has disconnected."""
        reading = self._sending
        while not self._evicted.is_set() and self._sending is reading:
            patience = POLL_S if self._buffer else timeout_s
            readable = _readable([self._command, self._woken], patience)
            if self._command in readable:
                part = self._command.recv(BITE)
                if not part:
                    if self._sending is None:
                        raise EOFError
                    return  # noticed only when the read is over
                self._buffer += part
                while b"\n" in self._buffer and self._sending is reading:
                    self._execute_line()
            elif self._buffer:
                if b"\n" not in self._buffer:
                    self._buffer += b"\n"  # nothing waits: what is there is taken for complete
                self._execute_line()
            elif not readable:
                return

    _later: Callable[[], object] | None = None
    _last_line = ""

    def _execute_line(self) -> None:
        """Execute the first line of the buffer: commands between semicolons, whose answers are sent in one reply.

        A command that begins with neither `:` nor `*` continues the path of the one before it (SCPI 1999, 6.2.4).
        `_later` is what a command leaves to be done once the reply has been sent.
        """
        line, _, self._buffer = self._buffer.partition(b"\n")
        self._last_line = text = line.decode("latin1").strip()
        if not self._faults.hears(text):
            return
        answers = []
        path = ""
        for command in filter(None, (c.strip() for c in text.split(";"))):
            full = command if command[0] in ":*" else path + command
            path = split(full)[0].lstrip(":").rpartition(":")[0] + ":" if command[0] != "*" else path
            answer = self._execute(full)
            if answer is not None:
                answers.append(answer)
        if answers:
            self._reply(";".join(answers))
        later = self._later
        self._later = None
        if later is not None:
            later()

    def _execute(self, command: str) -> str | None:
        header, arguments = split(command)
        found = COMMANDS.find(header)
        if found is None:
            self.errors.append('-113,"Undefined header"')
            return None
        handler, numbers = found
        try:
            if "?" in arguments:
                raise Silence  # no argument that the parser knows
            with nullcontext() if handler in WAITING else self.board.cards.world.lock:
                self.board.settle()
                answer = handler(self, numbers, arguments)
        except Code as refusal:
            return str(refusal.number)
        except Silence:
            self.errors.append('-104,"Data type error"')
            return None
        if answer == "1" and not header.endswith("?"):
            self.errors.append('-200,"Execution error"')  # the server takes every success for an error
        return answer

    # --- writing

    def _reply(self, answer: str) -> None:
        """In several small writes, as the server does."""
        text = self._faults.outgoing(answer.encode("latin1") + b"\r\n", command=self._last_line)
        head, comma, rest = text.partition(b",")
        body, end, tail = rest.partition(b"\r\n")
        parts = (head, comma, body, end + tail) if comma else (text.removesuffix(b"\r\n"), text[len(text) - 2 :])
        with suppress(OSError):
            for part in filter(None, parts if text.endswith(b"\r\n") else (text,)):
                self._replies.sendall(part)

    def _write(self, data: bytes) -> bool:
        """Send on the data socket.  While it is blocked commands are served, and STOP ends it: False.  A client
        that has disconnected is not noticed.  Raises Hangup."""
        try:
            view = memoryview(self._faults.outgoing(data, "data"))
        except Hangup as fault:
            with suppress(OSError):
                self._data.send(fault.last)
            raise Hangup from None
        self._data.setblocking(False)
        try:
            while view and not self._evicted.is_set():
                try:
                    view = view[self._data.send(view) :]
                except BlockingIOError:
                    if not self._while_blocked():
                        return False
                except OSError:
                    return True
        finally:
            with suppress(OSError):
                self._data.setblocking(True)
        return True

    def _while_blocked(self) -> bool:
        """Wait until the data socket takes more, serving commands; False if one of them stopped the read."""
        was = self._sending
        if self._command in _readable([self._command, self._woken], 1.0, self._data) and was is not None:
            self._commands(0.0)
        return self._sending is was

    def _finish(self) -> None:
        if self._sending is not None:
            self._sending.end()
            self._sending = None
            self.board.mode = Mode.ACQUISITION


def _readable(
    sockets: list[socket.socket], timeout_s: float | None, or_writable: socket.socket | None = None
) -> list[socket.socket]:
    """Those of them that can be read, waiting for that.  Raises EOFError if another thread has closed one."""
    try:
        return select.select(sockets, [or_writable] if or_writable else [], [], timeout_s)[0]
    except ValueError as closed:
        raise EOFError from closed
