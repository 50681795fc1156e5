"""The switch's and the LNA's controllers through pyserial."""

import os

import pytest
import serial

from drivers.errors import ConfigError
from sim_backend.emulators.emulator import LabEmulator
from sim_backend.emulators.wire_faults import WireFault
from tests.kit.emulator_client import LAB, configure, connect, control, program, start, tables, until


def opened(emulator, name):
    return serial.Serial(emulator.endpoints()["serial"][name], 115200, timeout=2, exclusive=True)


def ask(port, text, end=b"\n"):
    port.write(text.encode() + end)
    reply = port.readline()
    assert reply.endswith(b"\r\n"), reply
    return reply[:-2].decode()


@pytest.fixture
def switch(emulator):
    with opened(emulator, "switch") as port:
        yield port


@pytest.fixture
def lna(emulator):
    with opened(emulator, "lna") as port:
        yield port


def test_the_switch_tells_who_and_where_it_is(switch):
    assert ask(switch, "*idn?", b"\r\n").split(",") == ["Simulated", "Tx/Rx switch 3x", "S1", "1.0"]
    assert ask(switch, "POS?") == "TX"
    assert ask(switch, "TIM?") == "0.003,0.001,0.004"
    assert ask(switch, "FOLLOW?") == "1"


def test_contacts_move_on_command_and_are_read_back(switch):
    assert ask(switch, "POS RX") == "OK"
    until(lambda: ask(switch, "pos?") == "RX")
    assert ask(switch, "POS TX") == "OK"
    until(lambda: ask(switch, "POS?") == "TX")


@pytest.mark.parametrize(
    ("line", "reply"),
    [("POS SIDEWAYS", "ERR 2"), ("POS", "ERR 2"), ("FOLLOW MAYBE", "ERR 2"), ("GAIN?", "ERR 1"), ("?", "ERR 1")],
)
def test_what_the_switch_refuses(switch, line, reply):
    assert ask(switch, line).startswith(reply)


def test_the_switch_follows_the_cards_line_and_refuses_commands_while_a_shot_runs(emulator, switch):
    client = connect(emulator)
    configure(client)
    program(client, 1_000_000, [[0, 0, 0, 1.8]])
    start(client)
    until(lambda: ask(switch, "POS?") == "RX")
    assert ask(switch, "POS TX").startswith("ERR 3")
    client.do("RP:TRIGGER OFF")
    until(lambda: ask(switch, "POS?") == "TX")


def test_a_switch_that_does_not_follow_moves_by_its_own_commands_only(emulator, switch):
    assert ask(switch, "FOLLOW OFF") == "OK"
    client = connect(emulator)
    configure(client)
    program(client, 1_000_000, [[0, 0, 0, 1.8]])
    start(client)
    assert ask(switch, "FOLLOW?") == "0"
    assert ask(switch, "POS RX") == "OK"
    until(lambda: ask(switch, "POS?") == "RX")
    assert ask(switch, "POS TX") == "OK"
    until(lambda: ask(switch, "POS?") == "TX")
    assert ask(switch, "FOLLOW ON") == "OK"
    until(lambda: ask(switch, "POS?") == "RX")


def test_gain_is_set_and_read_back_and_never_rounded(lna):
    assert ask(lna, "GAINS?") == "1,10,40,100"
    assert ask(lna, "GAIN?") == "40"
    assert ask(lna, "GAIN 100") == "OK"
    assert ask(lna, "GAIN?") == "100"
    assert ask(lna, "GAIN 99").startswith("ERR 2")
    assert ask(lna, "GAIN lots").startswith("ERR 2")
    assert ask(lna, "GAIN?") == "100"


def test_overload_is_latched_until_it_is_cleared(emulator, lna):
    control(emulator, "inject", kind="lna_overload")
    client = connect(emulator)
    configure(client)
    program(client, 3000, [[0, 0, 1.8, 0], [0, 0, 0, 1.8]])
    start(client)
    until(lambda: ask(lna, "OVL?") == "1")
    client.do("RP:TRIGGER OFF")
    assert ask(lna, "OVL?") == "1"
    assert ask(lna, "OVL:CLR") == "OK"
    assert ask(lna, "OVL?") == "0"


def test_a_destroyed_lna_says_fault_and_stays_overloaded(emulator, lna):
    emulator.world.amplifier(enabled=True, muted=False)
    client = connect(emulator)
    configure(client)
    program(client, 3000, [[0, 0, 1.8, 1.8]])
    start(client)
    until(lambda: ask(lna, "OVL?") == "1")
    assert ask(lna, "GAIN?").startswith("ERR 4")
    ask(lna, "OVL:CLR")
    assert ask(lna, "OVL?") == "1"
    assert "live amplifier" in control(emulator, "violations")[0]["cause"]


@pytest.mark.parametrize(("kind", "left"), [("timeout", b""), ("half_reply", b"40\r\n"[:2]), ("garbage", None)])
def test_a_fault_of_the_wire_strikes_the_answer_it_is_told_to(emulator, lna, kind, left):
    control(emulator, "wire_fault", kind=kind, device="lna", after=1)
    lna.timeout = 0.2
    assert ask(lna, "GAIN?") == "40"
    lna.write(b"GAIN?\n")
    reply = lna.read(4)
    assert reply == left if left is not None else reply != b"40\r\n"
    lna.timeout = 2
    assert ask(lna, "GAIN?") == "40"


def test_an_unplugged_port_is_gone_and_comes_back_under_the_same_name(emulator):
    path = emulator.endpoints()["serial"]["lna"]
    port_of = os.readlink(path)
    with opened(emulator, "lna") as port:
        control(emulator, "wire_fault", kind="disconnect", device="lna", at_byte=1)
        port.write(b"GAIN?\n")
        until(lambda: os.readlink(path) != port_of)
        with pytest.raises((serial.SerialException, OSError)):
            port.read(100)
    with opened(emulator, "lna") as again:
        assert ask(again, "GAIN?") == "40"
    assert os.path.islink(path)


def test_garbage_is_the_same_for_the_same_seed(lab_with):
    seen = []
    for _ in range(2):
        emulator = lab_with()
        emulator.faults["lna"].arm(WireFault(kind="garbage", device="lna"))
        seen.append(emulator.faults["lna"].outgoing(b"1234\r\n"))
    assert seen[0] == seen[1] != b"1234\r\n"


def test_a_path_that_exists_is_left_alone(tmp_path):
    mine = tmp_path / "tty"
    mine.write_text("mine")
    table = tables()
    table["serial"]["lna"]["link"] = str(mine)
    with pytest.raises(ConfigError, match="exists"):
        LabEmulator(table, LAB.parent)
    assert mine.read_text() == "mine"


def test_the_switch_measures_how_long_its_contacts_took(emulator, switch):
    assert ask(switch, "MOVE? RX") == "0.000000"
    assert ask(switch, "FOLLOW OFF") == "OK"
    assert ask(switch, "POS RX") == "OK"
    until(lambda: ask(switch, "POS?") == "RX")
    dead_s, bounce_s, _ = (float(t) for t in ask(switch, "TIM?").split(","))
    until(lambda: not ask(switch, "MOVE? RX").startswith("ERR"))
    assert dead_s <= float(ask(switch, "MOVE? RX")) <= dead_s + bounce_s
    assert ask(switch, "MOVE?").startswith("ERR 2")
