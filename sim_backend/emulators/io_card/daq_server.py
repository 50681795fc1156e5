"""RedPitayaDAQServer as its clients meet it: a command port, a data port, and one client at a time.

A client is a pair of connections.  The server accepts a command connection, ends what the client before was doing, and
then waits on the data port for as long as it takes; only then does it read commands.
"""

from __future__ import annotations

import math
import socket
import threading
import time
from contextlib import suppress
from dataclasses import replace

from ..listening import hang_up, listening_socket
from ..wire_faults import WireFaults
from .board import Board
from .scpi_session import ScpiSession

MAIN_LOOP_S = 0.02
HANGS = 0.05  # share of the time in which it ends a client


class DaqServer:
    """One card's server on its two ports."""

    def __init__(self, board: Board, host: str, faults: WireFaults) -> None:
        self._board = board
        self._faults = faults
        self._commands = listening_socket(host, board.options.command_port, backlog=1)
        try:
            self._data = listening_socket(host, board.options.data_port, backlog=1)
        except Exception:
            self._commands.close()
            raise
        self.host = host
        self.command_port: int = self._commands.getsockname()[1]
        self.data_port: int = self._data.getsockname()[1]
        self._talk: ScpiSession | None = None
        self._ending: list[ScpiSession] = []
        self._closed = False
        self._over = threading.Event()
        self._half_open: socket.socket | None = None
        threading.Thread(target=self._accept, name="daq-accept", daemon=True).start()

    def close(self) -> None:
        """The process ends: both ports and the client's connections close.  Idempotent."""
        if self._closed:
            return
        self._closed = True
        self._over.set()
        for listener in (self._commands, self._data):
            hang_up(listener)
        if self._half_open is not None:
            hang_up(self._half_open)
        if self._talk is not None:
            self._talk.end()
        for talk in self._ending:
            talk.die()
        with self._board.cards.world.lock:
            left_alone(self._board)

    def _accept(self) -> None:
        with suppress(OSError):  # a listening socket was closed
            while not self._closed:
                command, _ = self._commands.accept()
                self._half_open = command
                left_over = self._evict(command)
                late = self._ends_twice()
                data, _ = self._data.accept()
                if late:
                    hang_up(data)  # by the thread that still ends the client before
                self._half_open = None
                self._talk = ScpiSession(self._board, command, data, self._faults, self.close, left_over)
                if self._closed:  # by now, and who closed it has not seen this client
                    self._talk.end()
                time.sleep(MAIN_LOOP_S)  # the main loop looks for the next client only now and then

    def _ends_twice(self) -> bool:
        """Whether a client comes while the one before, which has disconnected by itself, is still being ended.

        Two threads of the real server then wait for the end of the same third one: within a millisecond it hung 6 of 6
        times, until it was restarted, later the old thread closed the new client's data connection.
        """
        gone_s = self._ending[0].gone_s if self._ending else None
        ago_s = math.inf if gone_s is None else time.monotonic() - gone_s
        if ago_s < HANGS * self._board.options.ending_s:
            self._over.wait()
        return ago_s < self._board.options.ending_s

    def _evict(self, successor: socket.socket) -> bytes:
        """End the client before; what it had already sent is still answered, but to its successor.  Returns what is
        left in the parser's buffer, which the clients share."""
        before = self._talk
        self._talk = None
        self._ending = [] if before is None else [before]
        if before is not None and before.gone_s is None:
            clock = self._board.cards.world.clock
            left_over = before.end(successor)
            clock.wait_until(clock.monotonic_s() + self._board.clear_s(), self._over)  # the memory is emptied first
        else:
            left_over = b"" if before is None else before.end(successor)
        with self._board.cards.world.lock:
            self._board.client_changed()
        return left_over


def left_alone(board: Board) -> None:
    """The card continues without its server; called with the world's lock held."""
    board.settle()
    board.sequence.abandoned(board.elapsed())
    if board.triggered and board.registers.program is not None:
        board.write(replace(board.registers, program=board.sequence.program))
