"""The time that the server needs to write and to clear its sequence memory, as the real one was seen to take it.

The numbers of 250 ns per access are from the real server; here an access takes ten times as long in a world that runs
ten times as fast.
"""

import time

import pytest

from sim_backend.emulators.emulator import LabEmulator
from tests.kit.emulator_client import LAB, RATE, SPEED, configure, connect, program, start, tables

MEASURED_SET_S = {1: 0.0178, 2: 0.0354, 3: 0.0442, 4: 0.0550}
MEASURED_CLEAR_S = 0.044
STEP, STEPS = 16, 40
SLACK_S = 0.1  # a busy computer


@pytest.fixture(scope="module")
def slow():
    """A client of a card with its sequence memory."""
    options = tables()
    for board in options["io_cards"]["boards"]:
        board["memory_access_s"] = SPEED * 250e-9
    emulator = LabEmulator(options, LAB.parent)
    client = connect(emulator)
    configure(client)
    yield client
    client.close()
    emulator.close()


def set_s(client) -> float:
    began_s = time.monotonic()
    client.do("RP:DAC:SEQ:SET")
    return time.monotonic() - began_s


def play(client) -> float:
    """To the end of the sequence and of the clearing; how long the server said "running" after the last step, s."""
    began_s = time.monotonic()
    start(client)
    while int(client.ask("RP:STATUS?")) & 16:
        pass
    took_s = time.monotonic() - began_s - STEP * (STEPS + 1) / RATE / SPEED
    client.do("RP:TRIGGER OFF", "RP:MODE CONFIGURATION")
    return took_s


@pytest.mark.parametrize("channels", MEASURED_SET_S)
def test_arming_and_clearing_take_what_they_took_on_the_real_server(slow, channels):
    program(slow, STEP, [[0.0] * channels] * STEPS)
    cleared_s = play(slow)
    again_s = set_s(slow)  # the same sequence once more, nothing was uploaded
    play(slow)
    assert 0.93 * MEASURED_SET_S[channels] < again_s < MEASURED_SET_S[channels] + SLACK_S
    assert 0.93 * MEASURED_CLEAR_S < cleared_s < MEASURED_CLEAR_S + SLACK_S


def test_a_longer_sequence_takes_no_longer(slow):
    program(slow, STEP, [[0.0] * 2] * 10)
    play(slow)
    short_s = min(set_s(slow) for _ in range(3) if play(slow) or True)
    program(slow, STEP, [[0.0] * 2] * 1000)
    start(slow)
    while int(slow.ask("RP:STATUS?")) & 16:
        pass
    slow.do("RP:TRIGGER OFF", "RP:MODE CONFIGURATION")
    assert set_s(slow) < short_s + SLACK_S
    play(slow)


@pytest.mark.real_time
def test_while_the_memory_is_cleared_nothing_can_be_set(slow):
    program(slow, STEP, [[0.0] * 2] * STEPS)
    start(slow)
    time.sleep(STEP * (STEPS + 2) / RATE / SPEED + 0.3 * MEASURED_CLEAR_S)
    slow.do("RP:TRIGGER OFF", "RP:MODE CONFIGURATION")
    assert slow.ask("RP:DAC:SEQ:SET") == "-7"
    time.sleep(MEASURED_CLEAR_S)
    slow.do("RP:DAC:SEQ:SET")
    play(slow)


@pytest.mark.real_time
def test_a_second_set_writes_the_enable_bits_only(slow):
    program(slow, STEP, [[0.0] * 4] * STEPS)
    assert set_s(slow) < 0.7 * MEASURED_SET_S[4]
    play(slow)
