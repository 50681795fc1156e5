"""While a gate is high by command, the driver's patience is one for all that it waits for."""

from __future__ import annotations

import time
from collections.abc import Sequence

from drivers.red_pitaya.board import Board
from drivers.red_pitaya.haste import LAST_LOOK_S, Haste
from drivers.red_pitaya.lines import GATE_GRACE_S, Edge, PinLines
from drivers.red_pitaya.options import card_table
from drivers.timeline import DigitalLine

RATE_HZ, GATE_S, DELAY_S = 1000.0, 0.1, 0.06


class Patience:
    """Obeys, and notes how long each answer would have been waited for."""

    def __init__(self) -> None:
        self.given: list[float | None] = []

    def ask_all(self, commands: Sequence[str], timeout_s: float | None = None) -> list[str | int | float]:
        self.given.append(timeout_s)
        return [0 if "WP?" in command else "ON" if command.endswith("?") else 1 for command in commands]


def test_each_answer_has_what_is_left_of_all() -> None:
    haste = Haste(0.3, time.monotonic() + 0.2)
    assert haste.left_s() <= 0.2
    assert Haste(0.3, time.monotonic() + 9).left_s() == Haste(0.3).left_s() == 0.3
    assert Haste(0.3, time.monotonic() - 9).left_s() == LAST_LOOK_S


def test_answers_that_are_each_late_do_not_add_up_while_the_gate_is_high() -> None:
    table, server = card_table({"boards": [{"host": "127.0.0.1"}]}), Patience()
    board = Board(table.boards[0], table, [], is_last=True)
    vars(board).update(_connection=server)
    edges = [Edge(0, 0, "DIO7_P", high, DigitalLine.PA_GATE) for high in (True, False)]
    edges[1].sample = round(GATE_S * RATE_HZ)
    PinLines("", {0: board}, edges, DELAY_S * RATE_HZ, RATE_HZ).before_trigger()
    board.ask("RP:STATUS?")
    time.sleep(0.15)
    board.ask("RP:STATUS?")
    first_s, later_s = (float(s) for s in server.given[-2:] if s is not None)
    assert first_s <= DELAY_S + GATE_GRACE_S
    assert later_s <= GATE_S + DELAY_S + GATE_GRACE_S - 0.15
