"""The common trigger of several boards: the master's, carried to the others by the clock cable."""

from __future__ import annotations

import time
from collections.abc import Sequence

from drivers.errors import DeviceTimeout
from drivers.red_pitaya.board import Board


def start(boards: Sequence[Board]) -> None:
    """Trigger all boards, which must be in mode ACQUISITION.  Raises DeviceTimeout if one has not followed."""
    boards[0].ask("RP:TRIGGER ON")
    for board in boards:
        if board.ask("RP:TRIGGER?")[0] != "ON":
            raise DeviceTimeout(
                "the trigger did not reach the board",
                where=board.where,
                remedy="check the cable between the boards, and that this one is wired as a slave",
            )


def wait_for_sequences(boards: Sequence[Board], timeout_s: float) -> None:
    """Wait until every board has played its sequence to the end: only then may the trigger go off.

    Raises DeviceTimeout if one plays on.
    """
    deadline = time.monotonic() + timeout_s
    for board in boards:
        while board.playing():
            if time.monotonic() > deadline:
                raise DeviceTimeout(
                    "the sequence does not end", where=board.where, remedy="stop the card, which connects anew"
                )
            time.sleep(1e-3)


def end(boards: Sequence[Board]) -> None:
    """Trigger off and mode CONFIGURATION.

    The slaves' recordings are kept alive until the master's trigger is off, or theirs would be cut off in the middle.
    """
    for board in boards if len(boards) > 1 else ():
        board.ask("RP:TRIGGER:ALIVE ON")
    boards[0].ask("RP:TRIGGER OFF")
    for board in boards if len(boards) > 1 else ():
        board.ask("RP:TRIGGER:ALIVE OFF")
    for board in boards:
        board.ask("RP:MODE CONFIGURATION")
