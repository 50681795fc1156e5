"""RedPitayaDAQServer as its clients meet it: a command port, a data port, and one client at a time.

A client is a pair of connections.  The server accepts a command connection, ends what the client before was doing, and
then waits on the data port for as long as it takes; only then does it read commands.
"""

from __future__ import annotations

import socket
import threading
import time
from contextlib import suppress

from ..listening import hang_up, listening_socket
from ..wire_faults import WireFaults
from .board import Board
from .conversation import Conversation

MAIN_LOOP_S = 0.02


class DaqServer:
    """One card's server on its two ports."""

    def __init__(self, board: Board, host: str, faults: WireFaults) -> None:
        self._board, self._faults = board, faults
        self._commands = listening_socket(host, board.options.command_port, backlog=1)
        try:
            self._data = listening_socket(host, board.options.data_port, backlog=1)
        except Exception:
            self._commands.close()
            raise
        self.host = host
        self.command_port: int = self._commands.getsockname()[1]
        self.data_port: int = self._data.getsockname()[1]
        self._talk: Conversation | None = None
        self._closed = False
        self._half_open: socket.socket | None = None
        threading.Thread(target=self._accept, name="daq-accept", daemon=True).start()

    def close(self) -> None:
        """The process ends: both ports and the client's connections close."""
        self._closed = True
        for listener in (self._commands, self._data):
            hang_up(listener)
        if self._half_open is not None:
            hang_up(self._half_open)
        if self._talk is not None:
            self._talk.end()

    def _accept(self) -> None:
        with suppress(OSError):  # a listening socket was closed
            while not self._closed:
                command, _ = self._commands.accept()
                command.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._half_open = command
                left_over = self._evict(command)
                data, _ = self._data.accept()
                data.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._half_open = None
                self._talk = Conversation(self._board, command, data, self._faults, self.close, left_over)
                time.sleep(MAIN_LOOP_S)  # the main loop looks for the next client only now and then

    def _evict(self, successor: socket.socket) -> bytes:
        """End the client before; what it had already sent is still answered, but to its successor.  Returns what is
        left in the parser's buffer, which the clients share."""
        before, self._talk = self._talk, None
        left_over = b"" if before is None else before.end(successor)
        with self._board.cards.world.lock:
            self._board.client_changed()
        return left_over
