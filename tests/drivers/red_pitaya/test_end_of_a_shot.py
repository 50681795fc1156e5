"""When a shot is over: the trigger may fall only when the server has ended the sequence."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
import pytest

from drivers.errors import DeviceTimeout, ShotRefused
from drivers.red_pitaya import trigger
from drivers.red_pitaya.board import Board
from drivers.red_pitaya.emergency import EMERGENCY_PIN
from drivers.red_pitaya.options import card_table
from drivers.red_pitaya.scale import Scale
from drivers.red_pitaya.sequence import BoardProgram, Sine

TRIGGERED, PLAYING, VOLTS = 8, 16, 0.1


def sine(output: int, component: int, volts: float) -> Sine:
    """Of 212 Hz."""
    return Sine(output=output, component=component, frequency_hz=212.0, amplitude_v=volts, phase_rad=0.0)


UNIT_SCALE = Scale(scale_v=np.ones(2, "f4"), offset_v=np.zeros(2, "f4"), calibrated=True, output=(1.0, 1.0), gain=1.0)


class Server:
    """Answers like the real one, whose thread sees only at question `notices` that the card has been triggered: until
    then it does not say that it plays; at question `ends` it has zeroed the amplitudes, and at `rests` its memory."""

    def __init__(self, notices: int, ends: int, rests: int = 0, sends: int = 0) -> None:
        self._notices, self._ends, self._rests, self._sends = notices, ends, max(ends, rests), sends
        self.asked = 0

    def ask_all(self, commands: Sequence[str], timeout_s: float | None = None) -> list[str | int | float]:
        self.asked += any(c == "RP:STATUS?" for c in commands)
        plays = self._notices <= self.asked < self._rests
        volts = VOLTS if self.asked < self._ends else 0.0
        return [self._answer(c, plays=plays, volts=volts) for c in commands]

    def _answer(self, command: str, *, plays: bool, volts: float) -> str | int | float:
        if command == "RP:STATUS?":
            return TRIGGERED | PLAYING * plays
        if command == "RP:MODE?":
            return "TRANSMISSION" if self.asked < self._sends else "ACQUISITION"
        return volts if command.endswith("AMPLITUDE?") else 0


def armed(server: object, *sines: Sine) -> Board:
    """A board on such a server, with these sines."""
    table = card_table({"boards": [{"host": "127.0.0.1"}]})
    board = Board(table.boards[0], table, [], is_last=True)
    asked = [f"RP:DAC:CHANNEL{s.output}:COMPONENT{s.component}:AMPLITUDE?" for s in sines]
    vars(board).update(_connection=server, _sounding=asked)
    return board


@pytest.mark.parametrize("notices", [0, 7, 20])
def test_a_server_that_has_not_noticed_the_trigger_yet_is_waited_for(notices: int) -> None:
    server = Server(notices, ends=20)
    assert trigger.wait_for_sequences([armed(server, sine(0, 0, VOLTS))], 5.0) == []
    assert server.asked == 20


def test_a_server_that_never_notices_it_is_an_error() -> None:
    with pytest.raises(DeviceTimeout, match="does not end"):
        trigger.wait_for_sequences([armed(Server(10**6, 10**6), sine(1, 2, VOLTS))], 0.05)


def test_the_samples_do_not_wait_until_the_memory_is_empty_and_the_next_shot_does() -> None:
    server = Server(2, ends=20, rests=50)
    board = armed(server, sine(0, 0, VOLTS))
    assert trigger.wait_for_sequences([board], 5.0) == []
    assert server.asked == 20
    trigger.wait_until_cleared([board], 5.0)
    assert server.asked == 50
    trigger.wait_until_cleared([board], 5.0)
    assert server.asked == 50, "a server that rests is not asked again"


def test_the_next_shot_waits_a_moment_longer_than_the_server_says() -> None:
    board = armed(Server(0, ends=1, rests=2), sine(0, 0, VOLTS))
    assert trigger.wait_for_sequences([board], 5.0) == []
    since = time.monotonic()
    trigger.wait_until_cleared([board], 5.0)
    assert time.monotonic() - since >= trigger.REST_S


def test_a_memory_that_is_never_empty_is_an_error_of_the_next_shot() -> None:
    board = armed(Server(0, 1, rests=10**6), sine(0, 0, VOLTS))
    assert trigger.wait_for_sequences([board], 5.0) == []
    with pytest.raises(DeviceTimeout, match="shot before does not end"):
        trigger.wait_until_cleared([board], 0.05)


def test_a_server_that_sends_still_refuses_the_end_and_is_waited_for() -> None:
    server = Server(0, ends=3, sends=12)
    assert trigger.wait_for_sequences([armed(server, sine(0, 0, VOLTS))], 5.0) == []
    assert server.asked == 12


def test_a_memory_may_be_emptied_though_the_status_asked_before_did_not_say_so() -> None:
    """A thread of the server that was late for all of a short sequence starts and ends it between two answers."""
    server = Server(6, ends=5, rests=9)
    server.asked = 4
    board = armed(server, sine(0, 0, VOLTS))
    assert trigger.wait_for_sequences([board], 5.0) == []
    assert board.clearing
    trigger.wait_until_cleared([board], 5.0)
    assert server.asked == 9


def test_one_board_empties_its_memory_while_the_other_plays() -> None:
    quick, slow = Server(0, ends=2, rests=3), Server(0, ends=30, rests=60)
    boards = [armed(each, sine(0, 0, VOLTS)) for each in (quick, slow)]
    assert trigger.wait_for_sequences(boards, 5.0) == []
    assert (quick.asked, slow.asked) == (2, 30)
    trigger.wait_until_cleared(boards, 5.0)
    assert (quick.asked, slow.asked) == (3, 60)


class Arming:
    """Accepts every command; amplitudes read back as `volts`, one each."""

    def __init__(self, *volts: float) -> None:
        self._volts = list(volts)

    def ask_all(self, commands: Sequence[str], timeout_s: float | None = None) -> list[str | int | float]:
        return [self._volts.pop(0) if c.endswith("AMPLITUDE?") else int(c != EMERGENCY_PIN) for c in commands]


@pytest.mark.parametrize(("volts", "rests"), [((0.0, 0.0), 50), ((0.0, VOLTS), 20)])
def test_amplitudes_that_were_zero_all_along_tell_of_no_end(volts: tuple[float, float], rests: int) -> None:
    table = card_table({"boards": [{"host": "127.0.0.1"}]})
    board, server = Board(table.boards[0], table, [], is_last=True), Server(0, ends=20, rests=50)
    vars(board).update(_connection=Arming(*volts), scale=UNIT_SCALE)
    sines = tuple(sine(k, 0, v) for k, v in enumerate(volts))
    board.arm(BoardProgram(16, np.zeros((1, 2), "f4"), np.ones((1, 2), "u1"), sines))
    vars(board).update(_connection=server)
    assert trigger.wait_for_sequences([board], 5.0) == []
    assert server.asked == rests


def test_without_a_sine_the_sequence_is_over_when_the_memory_is_empty() -> None:
    """Nothing but the server's status tells of its end then."""
    server = Server(0, ends=20, rests=50)
    assert trigger.wait_for_sequences([armed(server)], 5.0) == []
    assert server.asked == 50


def test_a_board_that_plays_nothing_is_over_at_once() -> None:
    server = Server(10**6, 10**6)
    assert trigger.wait_for_sequences([armed(server)], 5.0) == []
    assert server.asked == 1


class Slow:
    """A board whose trigger goes only at question `off_at`; records the commands it received."""

    def __init__(self, off_at: int) -> None:
        self._off_at = off_at
        self.received: list[str] = []
        self._on = True
        self._looks = 0

    def ask_all(self, commands: Sequence[str], timeout_s: float | None = None) -> list[str | int | float]:
        self.received += commands
        if "RP:TRIGGER?" not in commands:
            return [1] * len(commands)
        self._looks += 1
        return ["ON" if self._looks < self._off_at else "OFF"]


def test_a_board_leaves_its_mode_only_when_its_trigger_has_gone() -> None:
    """Else the next sequence would begin at once, without a shot."""
    master, slave = Slow(1), Slow(4)
    trigger.end([armed(master), armed(slave)])
    assert slave.received == [
        "RP:TRIGGER:ALIVE ON",
        *4 * ["RP:TRIGGER?"],
        "RP:TRIGGER:ALIVE OFF",
        "RP:MODE CONFIGURATION",
    ]
    assert master.received[:3] == ["RP:ADC:WP?", "RP:TRIGGER:ALIVE ON", "RP:TRIGGER OFF"]
    with pytest.raises(DeviceTimeout, match="does not go from the board"):
        trigger.end([armed(Slow(1)), armed(Slow(10**9))])


@pytest.mark.parametrize(("slave", "fits"), [(900, False), (936, True), (1000, True), (1264, True), (1300, False)])
def test_a_board_that_began_its_recording_at_another_moment_is_refused(slave: int, fits: bool) -> None:
    """Asked between the master's 1000 and 1200 its write pointer lies between these, but for two granules."""
    boards = [armed(Server(0, 1)), armed(Server(0, 1))]
    boards[0].written, boards[1].written = 1000, slave
    if fits:
        trigger.check_in_step(boards, 1200)
    else:
        with pytest.raises(ShotRefused, match="did not record together"):
            trigger.check_in_step(boards, 1200)
