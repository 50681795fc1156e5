"""Joins the streams of the boards to one recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivers.io_card import Chunk, ChunkFlags
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.sequence import BoardProgram


class Reader:
    """Puts the boards' chunks together; each board's chunk i is taken before any board's chunk i + 1."""

    def __init__(
        self,
        boards: Sequence[Board],
        programs: Sequence[BoardProgram],
        *,
        start: int,
        total: int,
        chunk: int,
        start_samples: int = 0,
    ) -> None:
        """start: first raw sample; total: samples to read; chunk: samples per status record; start_samples: see
        `Continuity`."""
        self._boards = boards
        self._start = start
        self._total = total
        self._chunk = chunk
        self._accounts = [b.account(p, start_samples) for b, p in zip(boards, programs, strict=False)]
        self._silent = [program.silent for program in programs]
        self._received = self._given = 0
        self._rest: tuple[NDArray[np.float32], ChunkFlags] | None = None

    @property
    def left(self) -> int:
        """Samples not yet given out."""
        return self._total - self._given

    def read(self, most: int, arrived: Callable[[int], None]) -> Chunk:
        """The next min(most, left) samples; `arrived(n)` is called after each hardware chunk."""
        wanted = min(most, self.left)
        first = self._given
        pieces = []
        got = 0
        flags = ChunkFlags()
        while got < wanted:
            if self._rest is None:
                self._rest = self._receive()
                arrived(self._received)
            volts, verdict = self._rest
            piece = volts[:, : wanted - got]
            rest = volts[:, wanted - got :]
            self._rest = (rest, verdict) if rest.shape[1] else None
            pieces.append(piece)
            got += piece.shape[1]
            flags = flags | verdict
        self._given += got
        return Chunk(first, np.concatenate(pieces, axis=1), flags)

    def _receive(self) -> tuple[NDArray[np.float32], ChunkFlags]:
        count = min(self._chunk, self._total - self._received)
        rows = []
        flags = ChunkFlags()
        for board, account, silent in zip(self._boards, self._accounts, self._silent, strict=True):
            volts, verdict = board.next_chunk(self._start + self._received, count, account)
            board.watch()
            rows.append(volts)
            if silent:  # the flag stays until a sequence is set, and this board has no sequence that could lose steps
                verdict = replace(verdict, lost_steps=False)
            flags = flags | verdict
        self._received += count
        return np.concatenate(rows), flags
