"""What is done to all boards of a card."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from operator import methodcaller
from typing import TextIO

from drivers.errors import DeviceError, DeviceLost
from drivers.red_pitaya import trigger, watchdog_proof
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.haste import Haste
from drivers.red_pitaya.layout import Layout
from drivers.red_pitaya.lock import recording_until
from drivers.red_pitaya.options import CardTable
from drivers.red_pitaya.pairing import keep_clear
from drivers.red_pitaya.replay import ReplayBoard
from drivers.red_pitaya.sequence import RING_STEPS, BoardProgram

Step = Callable[[Board], None]
# Each board does it in its own way: `Board.quiet` would be that of a plain one.
QUIET: Step = methodcaller("quiet")
REPLACE: Step = methodcaller("replace")
SETTLE: Step = methodcaller("settle")


def make_boards(table: CardTable, layout: Layout) -> list[Board]:
    """The boards of a table, in its order, not connected."""
    kind, last = ReplayBoard if table.replay_watchdog else Board, len(table.boards) - 1
    lines = [(p.board, p.pin) for p in layout.lines.values() if p.sequence_channel is None]
    return [
        kind(address, table, [pin for board, pin in lines if board == k], is_last=k == last)
        for k, address in enumerate(table.boards)
    ]


def prove_boards(boards: Sequence[Board], table: CardTable) -> None:
    """What the table wants to be proved before the first shot.  Raises DeviceTimeout, DeviceFault."""
    if table.replay_watchdog:
        watchdog_proof.prove(boards)
    elif table.prove_wiring:
        trigger.prove(boards)


def connect_all(boards: Sequence[Board], locks: Sequence[TextIO]) -> None:
    """New connections to all boards, outputs off, also if some cannot be had.  Raises what RedPitayaCard does.

    A client that died in a recording is ended by the server when that is over, and its end may take the connection
    made meanwhile with it, within 0.1 s after that was proved: once, that is connected anew.
    """
    for lock in locks:
        keep_clear(recording_until(lock))
    _at_once([board.open for board in boards])
    try:
        for board in boards:
            board.settle()
    except DeviceLost:
        for step in (REPLACE, SETTLE):
            for board in boards:
                step(board)


def hear_within(boards: Sequence[Board], programs: Sequence[BoardProgram], rate_hz: float) -> None:
    """Wait for each board no longer than half the time after which it would play its gate again by itself.

    A server that hangs refills its memory no longer, which is a ring: the gate and the sines rise anew one round after
    the trigger, while a receiver on another board, whose server is well, may be connected.  Until then the amplifier
    must be off, so a silent board is given up in time for that, whatever the table's patience is.
    """
    for board, program in zip(boards, programs, strict=True):
        half_round_s = RING_STEPS * program.step_samples / rate_hz / 2
        board.haste = Haste(half_round_s) if half_round_s < board.table.sample_timeout_s else None


def arm_all(boards: Sequence[Board], programs: Sequence[BoardProgram]) -> None:
    """All boards at once, each takes some 50 ms; raises the first error when all have ended."""
    _at_once([partial(board.arm, program) for board, program in zip(boards, programs, strict=True)])


def _at_once(steps: Sequence[Callable[[], None]]) -> None:
    with ThreadPoolExecutor(len(steps)) as pool:
        begun = [pool.submit(step) for step in steps]
    for each in begun:
        each.result()


def failures_of(boards: Sequence[Board], step: Step) -> list[str]:
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
