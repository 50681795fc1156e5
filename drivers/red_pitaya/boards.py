"""What is done to all boards of a card."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import TextIO

from drivers.errors import DeviceError, DeviceLost
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.lock import recording_until
from drivers.red_pitaya.pairing import keep_clear


def connect_all(boards: Sequence[Board], locks: Sequence[TextIO]) -> None:
    """New connections to all boards, outputs off.  Raises what RedPitayaCard does.

    A client that died in a recording is ended by the server when that is over, and its end may take the connection
    made meanwhile with it, within 0.1 s after that was proved: once, that is connected anew.
    """
    for board, lock in zip(boards, locks, strict=True):
        keep_clear(recording_until(lock))
        board.open()
    try:
        for board in boards:
            board.settle()
    except DeviceLost:
        for step in (Board.replace, Board.settle):
            for board in boards:
                step(board)


def failures_of(boards: Sequence[Board], step: Callable[[Board], None]) -> list[str]:
    """Do it on all boards at once, whatever fails; what failed."""
    failures: list[str] = []

    def work(board: Board) -> None:
        try:
            step(board)
        except (DeviceError, OSError) as error:
            failures.append(str(error))

    threads = [threading.Thread(target=work, args=(board,)) for board in boards[1:]]
    for thread in threads:
        thread.start()
    work(boards[0])
    for thread in threads:
        thread.join()
    return failures
