"""SCPI devices that differ only in their tables, and what can be wrong with a wire."""

from __future__ import annotations

import socket
import threading

import pytest
import usb.core

from drivers import entry_points
from drivers.conformance import AmplifierContract, LnaContract
from drivers.errors import (
    ConfigError,
    DeviceDenied,
    DeviceFault,
    DeviceLost,
    DeviceNotFound,
    DeviceProtocolError,
    DeviceTimeout,
)
from drivers.exchange import Exchange
from drivers.scpi import usb_wire
from drivers.scpi.amplifier import ScpiAmplifier
from drivers.scpi.backend import ScpiBackend
from drivers.scpi.dialogue import number
from drivers.scpi.options import AmplifierCommands, Words
from drivers.scpi.wires import TcpWire
from drivers.testing import ScriptedWires, TcpDevice


class Standard:
    """An amplifier with the default commands."""

    def __init__(self) -> None:
        self.on, self.muted, self.fault, self.errors, self.broken = True, False, "", [], False

    def __call__(self, text: str) -> str | None:
        if text == "OUTP ON":
            if self.fault:
                self.errors.append('-200,"fault latched"')
            else:
                self.on = not self.broken
        elif text == "OUTP OFF":
            self.on = self.broken and self.on
        elif text in ("OUTP:MUTE ON", "OUTP:MUTE OFF"):
            self.muted = text.endswith("ON")
        elif text == "STAT:FAULT:RES":
            self.fault = ""
        return self._answer(text)

    def _answer(self, text: str) -> str | None:
        return {
            "*IDN?": "ACME,amplifier,1,1",
            "OUTP?": str(int(self.on)),
            "OUTP:MUTE?": str(int(self.muted)),
            "SYST:TEMP?": "31.5",
            "STAT:FAULT?": f'3,"{self.fault}"' if self.fault else '0,"none"',
            "STAT:CLIP?": "0",
            "SYST:ERR?": self.errors.pop(0) if text == "SYST:ERR?" and self.errors else '0,"No error"',
        }.get(text)


class Simple:
    """Another maker's: other words, no mute, no temperature, no error queue."""

    def __init__(self) -> None:
        self.on = True

    def __call__(self, text: str) -> str | None:
        if text.startswith("POWER "):
            self.on = text == "POWER 1"
        return {"ID?": "Simple Corp,X1", "POWER?": "ENABLED" if self.on else "disabled"}.get(text)


SIMPLE = AmplifierCommands(
    identify="ID?", clear="", error="", enable="POWER 1", disable="POWER 0", enabled="POWER?", mute="", unmute="",
    muted="", temperature="", fault="", reset_fault="", clipped="",
)  # fmt: skip
MODELS = {
    "default commands": (Standard, AmplifierCommands(), Words()),
    "another model by its table alone": (Simple, SIMPLE, Words(yes=("ENABLED",), no=("DISABLED",))),
}


def amplifier(device, commands=AmplifierCommands(), words=Words()):  # noqa: B008 frozen
    return ScpiAmplifier(Exchange("amplifier", ScriptedWires(device), identify=commands.identify), commands, words)


class TestAmplifierContract(AmplifierContract):
    @pytest.fixture(scope="class", params=list(MODELS))
    @classmethod
    def amplifier(cls, request):
        device, commands, words = MODELS[request.param]
        made = amplifier(device(), commands, words)
        yield made
        made.close()


class TestATrip(AmplifierContract):
    @pytest.fixture(scope="class")
    @classmethod
    def device(cls):
        return Standard()

    @pytest.fixture(scope="class")
    @classmethod
    def amplifier(cls, device):
        made = amplifier(device)
        yield made
        made.close()

    @pytest.fixture
    def trip(self, device):
        return lambda: setattr(device, "fault", "over-current")


def test_the_temperature_is_not_asked_where_an_answer_that_never_comes_would_cost_a_shot():
    device = Standard()
    asked = []
    made = amplifier(lambda text: (asked.append(text), device(text))[1])
    assert made.status_after_tx().temperature_c is None
    assert "SYST:TEMP?" not in asked
    assert made.status().temperature_c == 31.5


def test_an_amplifier_that_was_left_on_is_switched_off_at_the_start():
    for device, commands, words in MODELS.values():
        left_on = device()
        amplifier(left_on, commands, words)
        assert not left_on.on


def test_a_latched_fault_keeps_it_off_until_it_is_reset():
    device = Standard()
    made = amplifier(device)
    device.fault = "over-temperature"
    assert made.status().fault == "over-temperature"
    with pytest.raises(DeviceFault, match="over-temperature"):
        made.enable()
    assert not device.on
    made.reset_fault()
    made.enable()
    assert device.on


def test_a_reset_whose_cause_persists_is_a_fault_and_leaves_it_off():
    class Hot(Standard):
        def __call__(self, text):
            return None if text == "STAT:FAULT:RES" else super().__call__(text)

    device = Hot()
    made = amplifier(device)
    made.enable()
    made.unmute()
    device.fault = "over-temperature"
    with pytest.raises(DeviceFault, match=r"the fault stays: over-temperature.*cool down"):
        made.reset_fault()
    assert not device.on


def test_a_reset_switches_off_before_the_fault_goes():
    heard = []

    class Heard(Standard):
        def __call__(self, text):
            heard.append((text, self.on))
            return super().__call__(text)

    device = Heard()
    made = amplifier(device)
    made.enable()
    made.unmute()
    device.fault = "over-current"
    made.reset_fault()
    assert ("STAT:FAULT:RES", False) in heard


def test_a_model_without_a_reset_command_says_so():
    device = Standard()
    made = amplifier(device, AmplifierCommands(reset_fault=""))
    device.fault = "over-current"
    with pytest.raises(DeviceFault, match=r"reset_fault is empty.*mains off and on"):
        made.reset_fault()


def test_the_reset_command_is_that_of_the_table():
    class Other(Standard):
        def __call__(self, text):
            return super().__call__({"CLEAR:PROT": "STAT:FAULT:RES", "STAT:FAULT:RES": "?"}.get(text, text))

    device = Other()
    made = amplifier(device, AmplifierCommands(reset_fault="CLEAR:PROT"))
    device.fault = "over-current"
    made.reset_fault()
    assert made.status().fault is None


def test_a_fault_between_the_question_and_the_command_is_seen_in_the_error_queue():
    class Trips(Standard):
        def __call__(self, text):
            self.fault = "over-current" if text == "OUTP ON" else self.fault
            return super().__call__(text)

    device = Trips()
    made = amplifier(device)
    with pytest.raises(DeviceFault, match="fault latched"):
        made.enable()
    assert not device.on


def test_an_amplifier_that_is_enabled_in_the_middle_of_a_stop_is_told_once_more():
    """A shot that is stopped as it begins may still send its command, between those of the stop."""

    class Enabled(Standard):
        began = True

        def __call__(self, text):
            answer = super().__call__(text)
            if text == "OUTP OFF" and self.began:
                self.on, self.began = True, False
            return answer

    device = Enabled()
    device.began = False
    made = amplifier(device)
    made.enable()
    device.began = True
    made.disable()
    assert not device.on


def test_an_amplifier_that_stays_on_is_a_fault_not_a_success():
    device = Standard()
    made = amplifier(device)
    made.enable()
    device.broken = True
    with pytest.raises(DeviceFault, match=r"reads back on.*mains"):
        made.disable()


def test_a_device_that_tells_its_health_in_words_needs_only_the_words():
    class Wordy(Standard):
        health = "Ok"

        def _answer(self, text):
            return self.health if text == "STAT:FAULT?" else super()._answer(text)

    device = Wordy()
    driver = amplifier(device, words=Words(healthy=("OK", "READY")))
    driver.enable()
    assert driver.status().fault is None
    device.health = "OVERTEMP"
    assert driver.status().fault == "OVERTEMP"
    with pytest.raises(DeviceFault, match="OVERTEMP"):
        driver.enable()


def test_a_reconnect_never_leaves_it_on():
    device = Standard()
    wires = ScriptedWires(device)
    made = ScpiAmplifier(Exchange("amplifier", wires), AmplifierCommands(), Words())
    made.enable()
    made.unmute()
    wires.device = lambda text: None
    with pytest.raises(DeviceTimeout):
        made.status()
    wires.device = device
    assert not made.status().can_put_out_power
    assert not device.on


@pytest.mark.parametrize("answer", ["maybe", "2", '"1'])
def test_a_yes_or_no_that_is_neither_is_an_error(answer):
    class Odd(Standard):
        def _answer(self, text):
            return answer if text == "OUTP?" else super()._answer(text)

    with pytest.raises(DeviceProtocolError, match=r"OUTP\?"):
        amplifier(Odd())


@pytest.mark.parametrize(
    ("table", "complaint"),
    [
        ({"transport": "usb"}, "vendor_id and product_id"),
        ({"transport": "serial"}, "needs port"),
        ({"transport": "tcp"}, "needs host"),
        ({"transport": "gpib"}, "transport"),
        ({"transport": "tcp", "host": "a", "commands": {"enabel": "X"}}, "enabel"),
        ({"transport": "tcp", "host": "a", "commands": {"mute": ""}}, "go together"),
    ],
)
def test_a_table_that_cannot_work_is_refused(table, complaint):
    with pytest.raises(ConfigError, match=complaint):
        ScpiBackend({}).power_amplifier(table)


class TestLnaOverTcp(LnaContract):
    @pytest.fixture(scope="class")
    @classmethod
    def lna(cls):
        state = {"gain": "1"}

        def device(text):
            if text.startswith("AMPL "):
                state["gain"] = text[5:]
            return {"*IDN?": "ACME,LNA,2,1", "AMPL?": state["gain"], "OVER?": "no"}.get(text)

        served = TcpDevice(device)
        table = {
            "transport": "tcp", "host": "127.0.0.1", "tcp_port": served.port, "gains": [1.0, 20.0], "gain": 20.0,
            "commands": {"gain": "AMPL?", "set_gain": "AMPL {gain}", "overload": "OVER?", "clear_overload": ""},
            "words": {"yes": ["yes"], "no": ["no"]},
        }  # fmt: skip
        lna = ScpiBackend({}).lna(table)
        yield lna
        lna.close()
        served.close()


def test_a_thermometer_needs_only_its_table():
    with TcpDevice({"*IDN?": "ACME,PT100,1,1", "TEMP?": "21.25"}.get) as served:
        address = {"transport": "tcp", "host": "127.0.0.1", "tcp_port": served.port}
        thermometer = ScpiBackend({}).thermometer({**address, "commands": {"temperature": "TEMP?"}})
        assert thermometer.temperature_c() == 21.25
        thermometer.close()


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_end_as_the_table_says(end):
    with TcpDevice({"*IDN?": "ACME,PT100,1,1", "MEAS:TEMP?": "21.25"}.get, end) as served:
        table = {"transport": "tcp", "host": "127.0.0.1", "tcp_port": served.port, "line_end": end}
        thermometer = ScpiBackend({}).thermometer(table)
        assert [thermometer.temperature_c() for _ in range(2)] == [21.25, 21.25]
        assert served.heard == [f"{question}{end}".encode() for question in ("*IDN?", "MEAS:TEMP?", "MEAS:TEMP?")]
        thermometer.close()


def test_an_answer_that_breaks_off_is_none():
    listener = socket.create_server(("127.0.0.1", 0))

    def serve():
        link = listener.accept()[0]
        with link:
            for answer in (b"ACME,PT100,1,1\n", b"2"):
                link.recv(100)
                link.sendall(answer)

    threading.Thread(target=serve, daemon=True).start()
    table = {"transport": "tcp", "host": "127.0.0.1", "tcp_port": listener.getsockname()[1], "identity": "PT100"}
    thermometer = ScpiBackend({}).thermometer(table)
    with pytest.raises(DeviceLost, match="1 bytes"):
        thermometer.temperature_c()
    listener.close()


def test_nobody_at_the_address_is_not_found():
    free = socket.create_server(("127.0.0.1", 0))
    port = free.getsockname()[1]
    free.close()
    with pytest.raises(DeviceNotFound, match=str(port)):
        ScpiBackend({}).power_amplifier({"transport": "tcp", "host": "127.0.0.1", "tcp_port": port})


USB = {"transport": "usb", "vendor_id": 0x1209, "product_id": 0x0D0D, "timeout_s": 0.2}


def test_an_emulated_usb_device_needs_the_package_that_emulates_it(monkeypatch):
    monkeypatch.setattr(entry_points, "USB_BACKENDS", "platform_daemon.a_group_that_nobody_publishes_in")
    with pytest.raises(ConfigError, match=r"no USB back end is called 'socket'.*installed are: none"):
        ScpiBackend({}).power_amplifier({**USB, "socket": {"host": "127.0.0.1", "port": 1}})


def test_a_usb_device_that_is_not_there_is_not_found():
    closed = socket.create_server(("127.0.0.1", 0))
    port = closed.getsockname()[1]
    closed.close()
    with pytest.raises(DeviceNotFound, match="1209:0d0d"):
        ScpiBackend({}).power_amplifier({**USB, "socket": {"host": "127.0.0.1", "port": port}})


@pytest.mark.parametrize(
    ("error", "kind", "words"),
    [
        (usb.core.USBError("Access denied (insufficient permissions)", -3, 13), DeviceDenied, "udev"),
        (usb.core.USBError("Resource busy", -6, 16), DeviceDenied, "another program"),
        (usb.core.NoBackendError("No backend available"), DeviceNotFound, "libusb"),
        (ValueError("2 devices found:\nplease narrow"), DeviceNotFound, "2 devices found"),
    ],
)
def test_what_keeps_a_usb_device_from_being_opened_is_named(monkeypatch, error, kind, words):
    def failing(*args, **keys):
        raise error

    monkeypatch.setattr(usb_wire, "Device", failing)
    with pytest.raises(kind, match=words):
        ScpiBackend({}).power_amplifier(USB)


def test_a_usb_device_that_is_pulled_out_is_lost_and_one_that_sleeps_timed_out(monkeypatch):
    class Pulled:
        def __init__(self, *args, **keys):
            self.usb_dev = type("Device", (), {})()

        def clear(self):
            pass

        def write(self, data):
            return len(data)

        def read(self, size):
            raise self.error

        def close(self):
            pass

    monkeypatch.setattr(usb_wire, "Device", Pulled)
    for error, kind in (
        (usb.core.USBError("No such device", -4, 19), DeviceLost),
        (usb.core.USBTimeoutError("Operation timed out", -7, 110), DeviceTimeout),
    ):
        Pulled.error = error
        with pytest.raises(kind):
            ScpiBackend({}).power_amplifier(USB)


class _Talkative(threading.Thread):
    """A device that greets whoever connects, and says something unasked after every answer."""

    def __init__(self):
        super().__init__(daemon=True)
        self.listening = socket.create_server(("127.0.0.1", 0))

    def run(self):
        peer, _ = self.listening.accept()
        with peer, peer.makefile("rb") as lines:
            peer.sendall(b"Welcome to ACME\r\n> \r\n")
            for line in lines:
                peer.sendall(line.strip().lower() + b"\nunasked\n")


def test_what_a_device_says_unasked_is_no_answer():
    device = _Talkative()
    device.start()
    with device.listening:
        wire = TcpWire("127.0.0.1", device.listening.getsockname()[1], 5.0)
        for question in ("*IDN?", "TEMP?", "GAIN?"):
            wire.send(question)
            assert wire.receive() == question.lower()
        wire.close()


@pytest.mark.parametrize("said", ["9.91E37", "9.9E37", "-9.9E37", "nan", "inf", "", "no data"])
def test_what_stands_in_the_place_of_a_number_is_none(said):
    exchange = Exchange("thing", ScriptedWires(lambda text: "ACME,T,1,1" if "IDN" in text else said))
    with pytest.raises(DeviceProtocolError, match="makes no sense"):
        number(exchange, "TEMP?")
