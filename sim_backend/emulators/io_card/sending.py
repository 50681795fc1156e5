"""A read of samples in progress: chunks and their 21-byte records, at the pace at which the samples come into being."""

from __future__ import annotations

import struct
import threading
from collections.abc import Callable

from .board import Board

PERFORMANCE = struct.Struct("<QQ4B")
PIECE = 65536
CONTROL_MARGIN = 255
SET_DELAY = 0
NO_UPDATE = 255
IDLE_S = 0.01


class Sending:
    """One pipelined read.  `chunk()` sends the next chunk; `write` returns False if the read was stopped meanwhile."""

    def __init__(self, board: Board, start: int, count: int, chunk: int, write: Callable[[bytes], bool]) -> None:
        self._board = board
        self._write = write
        self._next = start
        self._stop = start + count
        self._chunk = chunk
        self.performance = bytes(PERFORMANCE.size)

    def over(self) -> bool:
        """True if everything has been sent."""
        return self._next >= self._stop

    def end(self) -> None:
        """Send no more."""
        self._stop = self._next

    def chunk(self, evicted: threading.Event) -> None:
        """Wait for and send one chunk and its record, unless the read is stopped or the client evicted."""
        last = min(self._next + self._chunk, self._stop)
        lag = sending = 0
        for first in range(self._next, last, PIECE):
            stop = min(first + PIECE, last)
            if not self._wait(stop, evicted):
                return
            with self._board.cards.world.lock:
                self._board.settle()
                before = self._board.write_pointer()
                if first == self._next:
                    self._board.strike(self._next, last)
                    lag = before - first
            if not self._write(self._board.samples(first, stop)):
                self.end()
                return
            sending += max(self._board.write_pointer() - before, 0)
        self.performance = PERFORMANCE.pack(max(lag, 0), sending, CONTROL_MARGIN, SET_DELAY, NO_UPDATE, SET_DELAY)
        self._next = last
        if not self._write(bytes([self._board.status()]) + self.performance):
            self.end()

    def _wait(self, stop: int, evicted: threading.Event) -> bool:
        """Until the samples up to `stop` exist, for ever if they never do; False if the client was evicted."""
        while not evicted.is_set():
            with self._board.cards.world.lock:
                if self._board.write_pointer() >= stop:
                    return True
                due_s = self._board.reached_s(stop) if self._board.triggered else None
            clock = self._board.cards.world.clock
            if due_s is None or due_s <= clock.monotonic_s():
                evicted.wait(IDLE_S)
            else:
                clock.wait_until(due_s, evicted)
        return False
