"""The common trigger of several boards: the master's, carried to the others by the clock cable.

The server looks at its command socket once a millisecond, so commands to one board are sent together if possible.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence

from drivers.errors import DeviceError, DeviceTimeout, ShotRefused
from drivers.red_pitaya.board import Board

FOLLOW_S = 0.1
OFF_S = 1.0
REST_S = 2e-3
LOOKS = 5  # at least: on a busy host a single question may take longer than the deadline
GRANULE = 32  # the write pointer goes in steps of so many samples, and a board may be one behind another


def start(boards: Sequence[Board]) -> None:
    """Trigger all boards, which must be in mode ACQUISITION.  Raises DeviceTimeout if one has not followed."""
    boards[0].ask("RP:TRIGGER ON")
    deadline = time.monotonic() + FOLLOW_S
    for board in boards:
        _wait_for(board, "ON", "the trigger did not reach the board", deadline)


def _wait_for(board: Board, level: str, otherwise: str, deadline_s: float) -> None:
    """Until the board's trigger has that level.  Raises DeviceTimeout if it has not by then."""
    looks = 0
    while board.ask("RP:TRIGGER?")[0] != level:
        looks += 1
        if time.monotonic() > deadline_s and looks >= LOOKS:
            raise DeviceTimeout(
                otherwise,
                where=board.where,
                remedy="check the cable between the boards, and that this one is wired as a slave",
            )


def wait_until_off(board: Board) -> None:
    """Wait until the board's trigger is off.  Raises DeviceTimeout if it does not go."""
    _wait_for(board, "OFF", "the trigger does not go from the board", time.monotonic() + OFF_S)


def prove(boards: Sequence[Board]) -> None:
    """Prove that the master's trigger reaches every board and leaves every board, with nothing to play.

    Raises DeviceTimeout: a loose cable, or a board that is not wired as a slave and so is a second master.
    """
    if len(boards) < 2:
        return
    for board in boards:
        board.ask("RP:MODE ACQUISITION")
    try:
        start(boards)
    except DeviceError:
        for board in boards:  # as far as they still answer
            with contextlib.suppress(DeviceError):
                board.ask("RP:TRIGGER OFF")
        raise
    end(boards)


def wait_for_sequences(boards: Sequence[Board], timeout_s: float) -> list[str]:
    """Wait until every board has played its sequence to the end, and its server has seen that and sends no more: only
    then may the trigger go off.

    Returns where the emergency input has switched the outputs off.  Raises DeviceTimeout if a sequence plays on.
    """
    deadline = time.monotonic() + timeout_s
    stopped = []
    for board in boards:
        while True:
            playing, emergency = board.play()
            if emergency:
                stopped.append(board.where)
            if emergency or not playing:
                break
            if time.monotonic() > deadline:
                raise DeviceTimeout(
                    "the sequence does not end", where=board.where, remedy="stop the card, which connects again"
                )
            time.sleep(1e-3)
    return stopped


def wait_until_cleared(boards: Sequence[Board], timeout_s: float) -> None:
    """Wait until every server has emptied its memory of the shot before.  Raises DeviceTimeout if one continues.

    A server reports this a moment before it has reset its count of steps.  A sequence that is set in between would lack
    its first steps, which are then enabled, without the gate's line (control.c:199, :387).
    """
    deadline = time.monotonic() + timeout_s
    waited = [board for board in boards if board.clearing]
    for board in waited:
        while not board.is_cleared():
            if time.monotonic() > deadline:
                raise DeviceTimeout(
                    "the sequence of the shot before does not end",
                    where=board.where,
                    remedy="stop the card, which connects again",
                )
            time.sleep(1e-3)
    if waited:
        time.sleep(REST_S)


def check_in_step(boards: Sequence[Board], at_the_end: int) -> None:
    """After `wait_for_sequences` and `end`: all boards have recorded since the same moment.

    A slave whose trigger was interrupted restarts recording and playing, so that its samples belong to a later time.
    Its server waits for them as for any others and notices nothing.  The write pointers of the slaves are therefore
    compared with that of the master, which is read once before and once after them.  An interruption that is closer to
    the trigger than these two readings, some milliseconds, is not detected.

    at_the_end: the write pointer that `end` returned, samples.  Raises ShotRefused.
    """
    master, *slaves = boards
    for board in slaves:
        if not master.written - 2 * GRANULE <= board.written <= at_the_end + 2 * GRANULE:
            raise ShotRefused(
                "the boards did not record together",
                where=board.where,
                why=f"at sample {master.written} to {at_the_end} of the first board this one was at {board.written}",
                remedy="check the clock and trigger cable between the boards, then repeat the shot",
            )


def end(boards: Sequence[Board]) -> int:
    """Trigger off, then all boards to mode CONFIGURATION; returns the master's write pointer before that.

    The slaves' recordings are kept alive until the master's trigger is off, or they would be cut off.  A sequence that
    is set while a board still has its trigger would begin and end at once, so this waits until the trigger is off.
    Raises DeviceTimeout if the trigger does not go from a board.
    """
    master, *slaves = boards
    for board in slaves:
        board.ask("RP:TRIGGER:ALIVE ON")
    written, *_ = master.ask("RP:ADC:WP?", *(["RP:TRIGGER:ALIVE ON"] if slaves else []), "RP:TRIGGER OFF")
    for board in boards:
        wait_until_off(board)
        board.ask(*(["RP:TRIGGER:ALIVE OFF"] if slaves else []), "RP:MODE CONFIGURATION")
    return int(written)
