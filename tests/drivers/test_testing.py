"""The published test kit does what it promises to the drivers of third parties."""

from __future__ import annotations

import socket

import pytest
import serial

from drivers.errors import DeviceLost, DeviceTimeout
from drivers.exchange import Exchange
from drivers.testing import ScriptedWire, ScriptedWires, SerialDevice, TcpDevice

LAMP = {"*IDN?": "ACME,lamp,7,1.2", "LIT?": "0"}


def test_a_wire_gives_answers_in_the_order_of_the_questions_and_late_lines_before_them():
    wire = ScriptedWire(LAMP.get, late=["old"])
    for line in ("*IDN?", "ON", "LIT?"):
        wire.send(line)
    assert [wire.receive() for _ in range(3)] == ["old", "ACME,lamp,7,1.2", "0"]
    assert wire.sent == ["*IDN?", "ON", "LIT?"]
    with pytest.raises(DeviceTimeout):
        wire.receive()


def test_an_error_in_the_place_of_an_answer_is_raised_and_the_exchange_lets_go():
    wires = ScriptedWires(lambda line: LAMP[line] if line == "*IDN?" else DeviceLost("unplugged"))
    lamp = Exchange("lamp", wires)
    with pytest.raises(DeviceLost, match="unplugged"):
        lamp.ask("LIT?")
    assert wires.opened[0].closed
    wires.device = LAMP.get
    assert lamp.ask("LIT?") == "0"
    assert wires.opened[1].sent == ["*IDN?", "LIT?"]


def test_a_new_device_speaks_on_wires_that_are_already_open():
    wires = ScriptedWires(LAMP.get)
    wire = wires()
    wires.device = {"LIT?": "1"}.get
    wire.send("LIT?")
    assert wire.receive() == "1"


def test_a_device_on_a_tcp_port_serves_one_connection_after_the_other_and_hangs_up_when_closed():
    with TcpDevice({"A": "a", "B": b"\xffraw"}.get) as device:
        for _ in range(2):
            with socket.create_connection(("127.0.0.1", device.port), 1.0) as peer:
                peer.sendall(b"A\nB")
                assert peer.recv(100) == b"a\n"
                peer.sendall(b"\n")
                assert peer.recv(100) == b"\xffraw"
        assert device.heard == [b"A\n", b"B\n"] * 2
        with socket.create_connection(("127.0.0.1", device.port), 1.0) as peer:
            peer.sendall(b"A\n")
            assert peer.recv(100) == b"a\n"
            device.close()
            assert peer.recv(100) == b""
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", device.port), 1.0)


def test_a_device_on_a_pseudo_terminal_answers_lines_and_bytes():
    with SerialDevice({"A": "a", "B": b"\xffraw"}.get) as device, serial.Serial(device.port, timeout=1.0) as port:
        port.write(b"A\nB")
        assert port.read(3) == b"a\r\n"
        port.write(b"\r\n")
        assert port.read(4) == b"\xffraw"
        device.close()
