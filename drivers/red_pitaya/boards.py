"""Actions on all boards of a card."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from drivers.errors import DeviceError, DeviceLost
from drivers.red_pitaya import trigger
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.layout import Layout
from drivers.red_pitaya.lock import CardLock
from drivers.red_pitaya.options import CardTable
from drivers.red_pitaya.pairing import keep_clear
from drivers.red_pitaya.reply_deadline import ReplyDeadline
from drivers.red_pitaya.sequence import RING_STEPS, BoardProgram

Step = Callable[[Board], None]


def make_boards(table: CardTable, layout: Layout) -> list[Board]:
    """The boards of a table, in its order, not connected."""
    last = len(table.boards) - 1
    lines = [(p.board, p.pin) for p in layout.lines.values() if p.sequence_channel is None]
    return [
        Board(address, table, [pin for board, pin in lines if board == k], is_last=k == last)
        for k, address in enumerate(table.boards)
    ]


def prove_boards(boards: Sequence[Board], table: CardTable) -> None:
    """Prove the wiring before the first shot, as far as the table demands it.  Raises DeviceTimeout."""
    if table.prove_wiring:
        trigger.prove(boards)


def connect_all(boards: Sequence[Board], locks: Sequence[CardLock]) -> None:
    """Open connections to all boards, with outputs off, also if some fail.  Raises as RedPitayaCard does.

    The server ends a client that died during a recording when the recording is over, which may close a connection that
    was made meanwhile, within 0.1 s after it was proved: in that case one new connection is made.
    """
    for lock in locks:
        keep_clear(lock.recording_until())
    _at_once([board.open for board in boards])
    try:
        for board in boards:
            board.settle()
    except DeviceLost:
        for step in (Board.replace, Board.settle):
            for board in boards:
                step(board)


def limit_reply_times(boards: Sequence[Board], programs: Sequence[BoardProgram], rate_hz: float) -> None:
    """Limit the wait for each board to half the time after which it would play its gate again by itself.

    A server that hangs stops refilling its memory, which is a ring: gate and sines are played again one round after the
    trigger, while the receiver on another board, whose server is well, may be connected.  The amplifier must be off by
    then, so a board that does not answer is given up in time, whatever `sample_timeout_s` of the table is.
    """
    for board, program in zip(boards, programs, strict=True):
        half_round_s = RING_STEPS * program.step_samples / rate_hz / 2
        board.reply_deadline = ReplyDeadline(half_round_s) if half_round_s < board.table.sample_timeout_s else None


def arm_all(boards: Sequence[Board], programs: Sequence[BoardProgram]) -> None:
    """Arm all boards at once (each takes some 50 ms); raises the first error after all have ended."""
    _at_once([partial(board.arm, program) for board, program in zip(boards, programs, strict=True)])


def _at_once(steps: Sequence[Callable[[], None]]) -> None:
    with ThreadPoolExecutor(len(steps)) as pool:
        begun = [pool.submit(step) for step in steps]
    for each in begun:
        each.result()


def failures_of(boards: Sequence[Board], step: Step) -> list[str]:
    """Run the step on all boards at once, even if it fails on some.  Returns the errors."""
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
