"""At the start, before anything can be energised: every card's watchdog acts, when it should, and lets go again."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence

from drivers.errors import DeviceError, DeviceFault
from drivers.red_pitaya import trigger
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.emergency import EMERGENCY
from drivers.red_pitaya.watchdog import (
    MISSING,
    REMEDY,
    STEPS,
    armed,
    check_armed,
    followers,
    lost_in_the_end,
    wire_missing,
)

COUNT = 320  # samples per step
SLACK = 128  # samples: the write pointer goes in steps of 32, and is behind by the card's filters
LONGEST_S = 1.0  # for a host that is very late


def prove(boards: Sequence[Board]) -> None:
    """Nothing is in the memories, all amplitudes are zero: the wires by level, then by the counters, all at once.

    Raises DeviceFault for a wire that is missing, goes elsewhere, or holds the emergency input; DeviceTimeout if the
    trigger does not reach a board, or does not go from it.
    """
    for board in boards:
        board.ask("RP:MODE CONFIGURATION", f"RP:COUNTER:SAMPLESPERSTEP {COUNT}", "RP:MODE ACQUISITION")
        _by_level(board)
    try:
        trigger.start(boards)
        _by_counter(boards)
    except DeviceError:
        for board in boards:  # as far as they still answer
            with contextlib.suppress(DeviceError):
                board.ask("RP:TRIGGER OFF")
        raise
    trigger.end(boards)
    for board in boards:
        latched, *_ = board.ask(EMERGENCY, "RP:MODE CONFIGURATION", "RP:COUNTER:SAMPLESPERSTEP 0")
        if latched:
            raise lost_in_the_end(board.where)


def _by_level(board: Board) -> None:
    try:
        check_armed(board.ask(*armed(0)), 0, COUNT, board.where)
    except DeviceFault as fault:
        if fault.what == MISSING and (pins := followers(board.ask)):
            raise wire_missing(board.where, f"a wire goes from DIO4_N to {', '.join(pins)}") from None
        raise


def _by_counter(boards: Sequence[Board]) -> None:
    """Each board's emergency input is pressed after STEPS * COUNT samples of its own clock, not before, and stays."""
    waiting, deadline_s = list(boards), time.monotonic() + LONGEST_S
    while waiting:
        for board in list(waiting):
            before, latched, after = board.ask("RP:ADC:WP?", EMERGENCY, "RP:ADC:WP?")
            if latched and int(after) < STEPS * COUNT - SLACK:
                raise _at_the_wrong_time(board.where, f"it was pressed before sample {after}")
            if not latched and (int(before) > STEPS * COUNT + SLACK or time.monotonic() > deadline_s):
                raise _at_the_wrong_time(board.where, f"it was not pressed until sample {before}")
            if latched:
                waiting.remove(board)


def _at_the_wrong_time(where: str, why: str) -> DeviceFault:
    return DeviceFault(
        "the watchdog does not press the emergency input when it should",
        where=where,
        why=f"{why}, and should be at {STEPS * COUNT}",
        remedy=REMEDY,
    )
