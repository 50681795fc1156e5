"""Serial devices: their protocol over a pseudo-terminal, and what can be wrong with a port."""

from __future__ import annotations

import threading

import pytest
import serial

from drivers import relay
from drivers.conformance import LnaContract
from drivers.errors import (
    DeviceDenied,
    DeviceFault,
    DeviceLost,
    DeviceNotFound,
    DeviceProtocolError,
    DeviceStateError,
    DeviceTimeout,
    InputError,
)
from drivers.serial_line import wire as wire_module
from drivers.serial_line.backend import SerialBackend
from drivers.serial_line.wire import SerialWire
from drivers.testing import SerialDevice
from drivers.tx_rx_switch import SwitchPosition


class Lna:
    def __init__(self) -> None:
        self.gain, self.overloaded = "10", "0"

    def __call__(self, line):
        if line.startswith("GAIN "):
            if line[5:] not in ("10", "40", "100"):
                return 'ERR 2,"no such gain"'
            self.gain = line[5:]
            return "OK"
        if line == "OVL:CLR":
            self.overloaded = "0"
            return "OK"
        known = {"*IDN?": "ACME,LNA,1,1", "GAIN?": self.gain, "GAINS?": "10,40,100", "OVL?": self.overloaded}
        return known.get(line, 'ERR 1,"unknown"')


class Switch:
    def __init__(self) -> None:
        self.position, self.stuck, self.busy = "TX", False, False

    def __call__(self, line):
        if line.startswith("POS "):
            if self.busy:
                return 'ERR 3,"not now"'
            self.position = self.position if self.stuck else line[4:]
            return "OK"
        if line == "FOLLOW ON":
            return "OK"
        known = {"*IDN?": "ACME,switch,1,1", "POS?": self.position, "TIM?": "0.003,0.001,0.004", "FOLLOW?": "1"}
        return known.get(line, 'ERR 1,"unknown"')


@pytest.fixture
def terminal():
    made = []

    def start(device):
        made.append(SerialDevice(device))
        return made[-1].port

    yield start
    for each in made:
        each.close()


class TestLnaContract(LnaContract):
    @pytest.fixture(scope="class")
    @classmethod
    def lna(cls):
        terminal = SerialDevice(Lna())
        lna = SerialBackend({}).lna({"port": terminal.port, "gain": 40.0})
        yield lna
        lna.close()
        terminal.close()


def test_the_lna_reports_an_overload_until_it_is_cleared(terminal):
    device = Lna()
    lna = SerialBackend({}).lna({"port": terminal(device), "gain": 40.0})
    assert not lna.overloaded()
    device.overloaded = "1"
    assert lna.overloaded()
    lna.clear_overload()
    assert not lna.overloaded()


def test_a_gain_that_the_lna_has_not_is_refused_at_the_start(terminal):
    with pytest.raises(InputError, match="no gain 20"):
        SerialBackend({}).lna({"port": terminal(Lna()), "gain": 20.0})


def test_an_lna_that_lost_its_power_gets_its_gain_back(terminal):
    device = Lna()
    deaf = []
    lna = SerialBackend({}).lna(
        {"port": terminal(lambda line: None if deaf else device(line)), "gain": 100.0, "timeout_s": 0.1}
    )
    deaf.append(True)
    with pytest.raises(DeviceTimeout):
        lna.gain()
    deaf.clear()
    device.gain = "10"
    assert lna.gain() == 100.0


def test_the_switch_goes_where_it_is_told_and_reads_back(terminal):
    switch = SerialBackend({}).tx_rx_switch({"port": terminal(Switch())})
    assert switch.position() is SwitchPosition.TRANSMIT
    switch.to_receive()
    assert switch.position() is SwitchPosition.RECEIVE
    assert switch.timing().total_s == pytest.approx(8e-3)
    switch.close()


def test_a_stuck_switch_is_a_fault(terminal, monkeypatch):
    monkeypatch.setattr(relay, "ARRIVAL_S", 0.01)
    device = Switch()
    switch = SerialBackend({}).tx_rx_switch({"port": terminal(device)})
    device.stuck = True
    with pytest.raises(DeviceFault, match="on transmit, not on receive"):
        switch.to_receive()


def test_a_switch_that_follows_a_running_shot_says_not_now(terminal):
    device = Switch()
    switch = SerialBackend({}).tx_rx_switch({"port": terminal(device)})
    device.busy = True
    with pytest.raises(DeviceStateError, match="not now"):
        switch.to_receive()


def test_the_wrong_device_on_the_port_is_refused(terminal):
    with pytest.raises(DeviceProtocolError, match="right device"):
        SerialBackend({}).tx_rx_switch({"port": terminal(Lna())})
    with pytest.raises(DeviceProtocolError, match="another device"):
        SerialBackend({}).lna({"port": terminal(Lna()), "gain": 40.0, "identity": "S/N 7"})


@pytest.mark.parametrize("garbage", [b"\xff\xfe\r\n", b"\r\n", b"1\x00\r\n"])
def test_garbage_is_named(terminal, garbage):
    with pytest.raises(DeviceProtocolError, match="garbage"):
        SerialBackend({}).lna({"port": terminal(lambda line: garbage), "gain": 40.0})


def test_half_an_answer_is_not_taken_for_one(terminal):
    port = terminal(lambda line: b"ACME,L")
    with pytest.raises(DeviceProtocolError, match="no end"):
        SerialBackend({}).lna({"port": port, "gain": 40.0, "timeout_s": 0.05})


def test_a_late_answer_is_not_taken_for_the_next_one(terminal):
    wire = SerialWire(terminal(lambda line: "late" if line == "A" else "B's"), 115200, 1.0)
    wire.send("A")
    threading.Event().wait(0.05)
    wire.send("B")
    assert wire.receive() == "B's"


def test_a_port_that_is_not_there_is_not_found(tmp_path):
    with pytest.raises(DeviceNotFound, match="no such serial port"):
        SerialWire(str(tmp_path / "ttyUSB9"), 115200, 0.1)


def test_a_port_is_used_by_one_program_only(terminal):
    port = terminal(Lna())
    first = SerialWire(port, 115200, 0.1)
    with pytest.raises(DeviceDenied, match="another program"):
        SerialWire(port, 115200, 0.1)
    first.close()


def test_permission_denied_names_the_udev_rule(monkeypatch):
    def denied(*args, **keys):
        raise serial.SerialException(13, "could not open port /dev/ttyUSB0: [Errno 13] Permission denied")

    monkeypatch.setattr(wire_module.serial, "Serial", denied)
    with pytest.raises(DeviceDenied, match="udev"):
        SerialWire("/dev/ttyUSB0", 115200, 0.1)


def test_a_line_that_breaks_is_lost():
    terminal = SerialDevice(Lna())
    wire = SerialWire(terminal.port, 115200, 0.2)
    terminal.close()

    def ask():
        wire.send("*IDN?")
        return wire.receive()

    with pytest.raises((DeviceLost, DeviceTimeout)):
        ask()
