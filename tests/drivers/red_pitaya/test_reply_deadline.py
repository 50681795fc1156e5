"""While a command keeps the gate high, one deadline limits all waiting, and the gate is low at the deadline."""

from __future__ import annotations

import threading
import time
from collections.abc import Sequence
from types import SimpleNamespace

import pytest

from drivers.errors import ShotRefused
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.gate_clock import GateClock
from drivers.red_pitaya.lines import GATE_GRACE_S, Edge, PinLines
from drivers.red_pitaya.options import card_table
from drivers.red_pitaya.reply_deadline import MIN_WAIT_S, ReplyDeadline
from drivers.red_pitaya.stream import Continuity
from drivers.timeline import DigitalLine

RATE_HZ, GATE_S, DELAY_S = 1000.0, 0.1, 0.06
END = round(GATE_S * RATE_HZ)
MOST_S = DELAY_S + GATE_GRACE_S
OFF = "RP:DIO:PIN7:SIDEP OFF"


class Scripted:
    """Obeys, and records the commands it received and the time-outs of answers and samples."""

    def __init__(self) -> None:
        self.received: list[str] = []
        self.given: list[float | None] = []
        self.low = threading.Event()
        self.pad = "OFF"

    def ask_all(self, commands: Sequence[str], timeout_s: float | None = None) -> list[str | int | float]:
        self.given.append(timeout_s)
        self.received += commands
        self.pad = next((c.split()[1] for c in commands if c.startswith("RP:DIO") and " " in c), self.pad)
        return [0 if "WP?" in command else self.pad if command.endswith("?") else 1 for command in commands]

    def receive_into(self, target: memoryview, timeout_s: float) -> None:
        self.given.append(timeout_s)
        raise TimeoutError

    def send_final(self, commands: Sequence[str]) -> None:
        if OFF in commands:
            self.low.set()


def board_of(server: Scripted) -> Board:
    table = card_table({"boards": [{"host": "127.0.0.1"}]})
    board = Board(table.boards[0], table, ["DIO7_P"], is_last=True)
    vars(board).update(_connection=server, _buffer=bytearray(1000))
    return board


@pytest.fixture
def servers() -> list[Scripted]:
    return [Scripted(), Scripted()]


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """A monotonic clock that only the test advances, for all but the timer."""
    fixed = SimpleNamespace(now_s=time.monotonic() + 1000.0)
    for module in ("reply_deadline", "lines"):
        fake = SimpleNamespace(monotonic=lambda: fixed.now_s)
        monkeypatch.setattr(f"drivers.red_pitaya.{module}.time", fake)
    return fixed


def lines_of(servers: Sequence[Scripted]) -> PinLines:
    """A gate on a pin of the second of two boards, high from the start on."""
    edges = [Edge(sample, 1, "DIO7_P", sample == 0, DigitalLine.PA_GATE) for sample in (0, END)]
    pins = PinLines(
        where="",
        boards=dict(enumerate(map(board_of, servers))),
        edges=edges,
        delay_samples=DELAY_S * RATE_HZ,
        rate_hz=RATE_HZ,
    )
    pins.before_trigger()
    return pins


def given_to(pins: PinLines, servers: Sequence[Scripted]) -> list[float | None]:
    """How long each board would be waited for now, for an answer and for samples."""
    for board in pins.boards.values():
        board.ask("RP:STATUS?")
        with pytest.raises(TimeoutError):
            board.next_chunk(0, 4, Continuity("", 0, 0))
    return [each for server in servers for each in server.given[-2:]]


def test_each_wait_has_what_is_left_of_all(servers: list[Scripted], clock: SimpleNamespace) -> None:
    pins = lines_of(servers)
    assert given_to(pins, servers) == [MOST_S] * 4
    clock.now_s += GATE_S + 0.1
    assert given_to(pins, servers) == pytest.approx([MOST_S - 0.1] * 4)
    clock.now_s += 9.0
    assert given_to(pins, servers) == [MIN_WAIT_S] * 4


def test_with_the_gate_low_the_table_says_how_long_again(servers: list[Scripted], clock: SimpleNamespace) -> None:
    pins = lines_of(servers)
    pins.at(END)
    assert servers[1].received[-3:] == [OFF, "RP:DIO:PIN7:SIDEP?", "RP:ADC:WP?"]
    assert given_to(pins, servers) == [None, 5.0] * 2


def test_a_timeout_without_a_deadline_is_the_same_for_each_answer() -> None:
    assert ReplyDeadline(0.3).remaining_s() == 0.3


def test_a_gate_whose_end_no_sample_tells_is_lowered_by_the_clock(servers: list[Scripted]) -> None:
    pins = lines_of(servers)
    pins.check()
    assert servers[1].low.wait(10.0)
    assert not servers[0].low.is_set()
    with pytest.raises(ShotRefused, match="before its end was seen"):
        pins.at(2)


def test_a_clock_that_was_stopped_in_time_does_nothing_and_one_that_was_not_says_so() -> None:
    rang = threading.Event()
    early = GateClock(time.monotonic() + 0.3, rang.set)
    early.stop("")
    assert not rang.wait(0.5)
    late = GateClock(time.monotonic() - 1.0, rang.set)
    assert rang.wait(10.0)
    with pytest.raises(ShotRefused, match="before its end was seen"):
        late.stop("")


def test_a_stop_lowers_the_lines_before_it_waits_for_a_new_connection(
    servers: list[Scripted], monkeypatch: pytest.MonkeyPatch
) -> None:
    board, done = board_of(servers[0]), list[bool]()
    monkeypatch.setattr("drivers.red_pitaya.board.take_over", lambda *_: done.append(servers[0].low.is_set()))
    board.replace()
    assert done == [True]
