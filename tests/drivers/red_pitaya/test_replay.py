"""A shot that stays in the card's memory: when its watchdog acts, and what is asked of it before each shot."""

from __future__ import annotations

import numpy as np
import pytest

from drivers.errors import ConfigError, DeviceError, DeviceFault, DeviceProtocolError, SequenceRejected, ShotRefused
from drivers.red_pitaya.options import card_table
from drivers.red_pitaya.replay import ReplayBoard
from drivers.red_pitaya.sequence import BoardProgram, Sine
from drivers.red_pitaya.stream import RECORD, Record
from drivers.red_pitaya.watchdog import WRITTEN_STEPS, armed, check_armed, counter_step, longest_shot

RATE_HZ = 125e6 / 2048
ON, OFF = "ON", "OFF"


SINES = (Sine(0, 0, 212.0, 0.3, 0.0),)


def program(steps=185, step=128, volts=0.0, sines=SINES):
    """A board's program of so many steps, each so many samples."""
    return BoardProgram(step, np.full((steps, 3), volts, np.float32), np.ones((steps, 3), np.uint8), sines)


def test_the_watchdog_acts_when_the_shot_is_over_and_half_a_second_is_too_and_no_earlier():
    shot = program()
    step = counter_step([shot, program(1)], 23_600, RATE_HZ, 2048)
    assert 4 * step == pytest.approx(shot.samples + 0.5 * RATE_HZ, abs=4)
    assert 4 * counter_step([program(1)], 60_000, RATE_HZ, 2048) == pytest.approx(60_000 + 0.5 * RATE_HZ, abs=4)


def test_the_watchdog_acts_before_the_memory_has_steps_that_nobody_wrote():
    step = counter_step([program(7000, 16)], 100, RATE_HZ, 2048)
    assert 7000 * 16 < 4 * step <= WRITTEN_STEPS * 16


@pytest.mark.parametrize(
    ("steps", "step", "recorded", "decimation", "complaint"),
    [
        (7372, 16, 100, 2048, "7372 steps"),
        (7200, 16, 100, 2048, "7372 steps"),
        (10, 16, 118_000, 2048, "7372 steps"),
        (100, 65536, 6_500_000, 8192, "counter is too short"),
    ],
)
def test_a_shot_that_memory_or_counter_cannot_hold_is_refused(steps, step, recorded, decimation, complaint):
    with pytest.raises(SequenceRejected, match=f"{complaint}.*replay_watchdog = false"):
        counter_step([program(steps, step)], recorded, 125e6 / decimation, decimation)


def test_the_longest_shot_is_one_that_is_not_refused():
    assert counter_step([program(1, 128)], longest_shot(16, RATE_HZ), RATE_HZ, 2048)


GOOD = [128, 1337, ON, 0, 1, ON, 1, 1, OFF, 0]


@pytest.mark.parametrize(
    ("place", "answer", "kind", "complaint"),
    [
        (0, 16, DeviceProtocolError, "lost the watchdog.*restarted"),
        (1, 0, DeviceProtocolError, "lost the watchdog.*restarted"),
        (2, OFF, DeviceProtocolError, "lost the watchdog.*restarted"),
        (3, 1, DeviceFault, "keeps the outputs off.*high before"),
        (5, OFF, DeviceFault, "DIO4_N does not follow"),
        (6, 0, DeviceFault, "wire from DIO4_N to DIO3_P is missing.*connect DIO4_N"),
        (8, ON, DeviceFault, "DIO4_N does not follow"),
        (9, 1, DeviceFault, "keeps the outputs off.*high after"),
    ],
)
def test_each_answer_before_a_shot_that_is_wrong_is_one_error(place, answer, kind, complaint):
    assert len(armed(128)) == len(GOOD)
    check_armed(GOOD, 128, 1337, "card")
    check_armed(GOOD[1:], 0, 1337, "card")
    with pytest.raises(kind, match=f"^card: .*{complaint}"):
        check_armed([*GOOD[:place], answer, *GOOD[place + 1 :]], 128, 1337, "card")


class Server:
    """Answers what it is told to answer, by command; 1 to the rest."""

    def __init__(self, **answers):
        self.answers, self.told = answers, []

    def ask_all(self, commands, timeout_s=None):
        self.told += commands
        return [self.answers.get(command.split(":", 1)[1], 1) for command in commands]


def board(answers=(), *, held=True):
    """A board on such a server that has armed a shot of 0.1 V."""
    table = card_table({"boards": [{"host": "127.0.0.1"}], "replay_watchdog": True})
    made = ReplayBoard(table.boards[0], table, [], is_last=True)
    sounding = ["RP:DAC:CHANNEL0:COMPONENT0:AMPLITUDE?"]
    usual = {"STATUS?": 8, "INSTANTRESET:TRIGGERED?": 0, "ADC:WP?": 24_000, sounding[0][3:]: 0.1}
    vars(made).update(
        _connection=Server(**{**usual, **dict(answers)}), _sounding=sounding, _armed_v=[0.1], counter_step=10_000,
        _held=program() if held else None, _held_step=10_000,
    )  # fmt: skip
    return made


def test_a_shot_is_over_when_trigger_and_amplitudes_are_as_they_were():
    assert board().play() == (False, False)


def test_a_server_that_sends_still_is_waited_for():
    assert board({"MODE?": "TRANSMISSION"}).play() == (True, False)


@pytest.mark.parametrize(
    ("answers", "kind", "complaint"),
    [
        ({"STATUS?": 0}, ShotRefused, "ended early"),
        ({"STATUS?": 24}, ShotRefused, "ended early"),
        ({"DAC:CHANNEL0:COMPONENT0:AMPLITUDE?": 0.0}, ShotRefused, "ended early"),
        ({"INSTANTRESET:TRIGGERED?": 1}, DeviceFault, "emergency input switched the outputs off"),
        ({"INSTANTRESET:TRIGGERED?": 1, "ADC:WP?": 40_000}, ShotRefused, "too late for the end of the shot"),
    ],
)
def test_an_end_that_is_another_one_is_named(answers, kind, complaint):
    with pytest.raises(kind, match=complaint):
        board(answers).play()


def test_a_server_that_plays_a_sequence_of_its_own_is_found_in_the_records():
    account = board().account(program(), 6103)
    for status in (8, 8):
        account.check(Record.parse(RECORD.pack(status, 100, 0, 0, 0, 0, 0), 0))
    with pytest.raises(ShotRefused, match="a sequence of its own"):
        account.check(Record.parse(RECORD.pack(8 | 16, 100, 0, 0, 0, 0, 0), 0))


def test_what_may_be_played_again_has_the_same_steps_and_the_same_watchdog():
    held = board()
    assert held.holds(program())
    assert held.holds(program(sines=(Sine(0, 0, 300.0, 0.1, 0.0),)))  # sines are told each time
    assert not held.holds(program(186))
    assert not held.holds(program(volts=1.8))
    assert not held.holds(program(step=64))
    assert not held.holds(program(sines=()))
    held.counter_step += 1
    assert not held.holds(program())
    assert not board(held=False).holds(program())


def test_a_memory_that_is_not_empty_is_never_written_over():
    full = board()
    with pytest.raises(DeviceError, match="holds another shot"):
        full.arm(program(186))
    assert vars(full)["_connection"].told == []


@pytest.mark.parametrize("answers", [{"TRIGGER?": ON, "STATUS?": 0}, {"TRIGGER?": OFF, "STATUS?": 8}])
def test_a_stop_with_a_shot_in_the_memory_fails_if_the_trigger_is_on(answers, monkeypatch):
    monkeypatch.setattr(ReplayBoard, "switch_off", lambda self: None)
    with pytest.raises(DeviceError, match="the trigger is on"):
        board(answers).quiet()


BOARD = {"host": "127.0.0.1"}
BOARDS = [BOARD, {"host": "127.0.0.2"}]


@pytest.mark.parametrize(
    ("table", "complaint"),
    [
        ({"instant_reset": False}, "needs instant_reset = true.*emergency input"),
        ({"prove_wiring": False}, "needs prove_wiring = true"),
        ({"trigger": "external"}, "needs trigger = internal"),
        ({"lines": {"pa_gate": {"pin": "DIO7_P"}, "rx_connect": {"pin": "AO1"}}}, "timed by different clocks"),
        *(
            ({"lines": {"pa_gate": {"pin": gate}, "rx_connect": {"pin": receiver}}}, f"line on {bad}.*watchdog's")
            for gate, receiver, bad in (
                ("DIO7_P", "DIO4_N", "DIO4_N"),
                ("DIO2_N", "DIO7_P", "DIO2_N"),
                ("DIO7_P", "DIO3_N", "DIO3_N"),
            )
        ),
    ],
)
def test_what_the_option_does_not_go_with_is_refused_by_name(table, complaint):
    with pytest.raises(ConfigError, match=complaint):
        card_table({"boards": BOARDS, "replay_watchdog": True, **table}).layout()
    assert card_table({"boards": [BOARD], "replay_watchdog": True})


@pytest.mark.parametrize("gate", [0, 1])
def test_lines_on_dio_pins_may_go_with_it(gate):
    lines = {"pa_gate": {"board": gate, "pin": "DIO7_P"}, "rx_connect": {"pin": "DIO7_N"}}
    assert card_table({"boards": BOARDS, "replay_watchdog": True, "lines": lines}).layout()
