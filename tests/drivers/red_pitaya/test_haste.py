"""While a gate is high by command, the driver's patience is one for all it waits for, and the gate low at its end."""

from __future__ import annotations

import time
from collections.abc import Sequence

import pytest

from drivers.errors import ShotRefused
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.haste import LAST_LOOK_S, Haste
from drivers.red_pitaya.lines import GATE_GRACE_S, Edge, PinLines
from drivers.red_pitaya.options import card_table
from drivers.red_pitaya.stream import Continuity
from drivers.timeline import DigitalLine

RATE_HZ, GATE_S, DELAY_S = 1000.0, 0.1, 0.06
END = round(GATE_S * RATE_HZ)


class Scripted:
    """Obeys, and notes what it was told, and how long answers and samples would have been waited for."""

    def __init__(self) -> None:
        self.told: list[str] = []
        self.given: list[float | None] = []
        self.samples: list[Haste] = []
        self.pad = "OFF"

    def ask_all(self, commands: Sequence[str], timeout_s: float | None = None) -> list[str | int | float]:
        self.given.append(timeout_s)
        self.told += commands
        self.pad = next((c.split()[1] for c in commands if c.startswith("RP:DIO") and " " in c), self.pad)
        return [0 if "WP?" in command else self.pad if command.endswith("?") else 1 for command in commands]

    def receive_into(self, target: memoryview, haste: Haste) -> None:
        self.samples.append(haste)
        raise TimeoutError


def board_of(server: Scripted) -> Board:
    table = card_table({"boards": [{"host": "127.0.0.1"}]})
    board = Board(table.boards[0], table, [], is_last=True)
    vars(board).update(_connection=server, _buffer=bytearray(1000))
    return board


@pytest.fixture
def lines() -> tuple[PinLines, list[Scripted]]:
    """A gate on a pin of the second of two boards, high from the start on."""
    servers = [Scripted(), Scripted()]
    edges = [Edge(sample, 1, "DIO7_P", sample == 0, DigitalLine.PA_GATE) for sample in (0, END)]
    pins = PinLines("", dict(enumerate(map(board_of, servers))), edges, DELAY_S * RATE_HZ, RATE_HZ)
    pins.before_trigger()
    return pins, servers


def test_each_answer_has_what_is_left_of_all() -> None:
    haste = Haste(0.3, time.monotonic() + 0.2)
    assert 0.1 < haste.left_s() <= 0.2
    assert Haste(0.3, time.monotonic() + 9).left_s() == Haste(0.3).left_s() == 0.3
    assert Haste(0.3, time.monotonic() - 9).left_s() == LAST_LOOK_S


def test_a_chunk_has_until_the_end_of_all_and_a_last_look() -> None:
    now_s = time.monotonic()
    assert Haste(0.3, now_s + 0.2).by_s() == now_s + 0.2
    assert LAST_LOOK_S <= Haste(0.3, now_s - 9).by_s() - now_s < LAST_LOOK_S + 1.0


def test_answers_that_are_each_late_do_not_add_up_while_the_gate_is_high(
    lines: tuple[PinLines, list[Scripted]],
) -> None:
    pins, servers = lines
    most_s = DELAY_S + GATE_GRACE_S
    for board, server in zip(pins.boards.values(), servers, strict=True):
        board.ask("RP:STATUS?")
        assert server.given[-1] == most_s
        assert board.haste is not None
        over_s = board.haste.until_s - time.monotonic()
        assert most_s < over_s <= GATE_S + most_s
    time.sleep(GATE_S + 0.05)
    for board, server in zip(pins.boards.values(), servers, strict=True):
        board.ask("RP:STATUS?")
        assert (server.given[-1] or 9) < most_s


def test_samples_are_waited_for_as_long_as_answers(lines: tuple[PinLines, list[Scripted]]) -> None:
    pins, servers = lines
    for board, server in zip(pins.boards.values(), servers, strict=True):
        with pytest.raises(TimeoutError):
            board.next_chunk(0, 4, Continuity("", 0, 0))
        assert server.samples == [board.haste]


def test_with_the_gate_low_the_table_says_how_long_again(lines: tuple[PinLines, list[Scripted]]) -> None:
    pins, servers = lines
    pins.at(END)
    assert servers[1].told[-3:] == ["RP:DIO:PIN7:SIDEP OFF", "RP:DIO:PIN7:SIDEP?", "RP:ADC:WP?"]
    for board, server in zip(pins.boards.values(), servers, strict=True):
        board.ask("RP:STATUS?")
        assert server.given[-1] is None


def test_a_gate_whose_end_does_not_come_with_the_samples_is_lowered_by_the_clock(
    lines: tuple[PinLines, list[Scripted]],
) -> None:
    pins, servers = lines
    pins.at(1)
    assert servers[1].pad == "ON"
    time.sleep(GATE_S + DELAY_S + GATE_GRACE_S)
    with pytest.raises(ShotRefused, match="before its end was seen"):
        pins.at(2)
    assert servers[1].pad == "OFF"


def test_a_stop_lowers_the_lines_before_it_waits_for_a_new_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    server, done = Scripted(), list[str]()
    board = board_of(server)
    board.output_pins.append("DIO7_P")
    vars(server)["call_out"] = done.extend
    monkeypatch.setattr("drivers.red_pitaya.board.take_over", lambda *_: done.append("connects anew"))
    board.replace()
    assert done == ["RP:DIO:PIN7:SIDEP OFF", "connects anew"]
