"""The amplifier through pyusb, as a driver would use it."""

import errno
import struct
from array import array

import pytest
import usb.core
import usb.util

from drivers.errors import DeviceTimeout
from drivers.scpi.options import AmplifierTable
from drivers.scpi.usb_wire import UsbWire
from sim_backend.emulators.usb.amplifier import AmplifierScpi
from sim_backend.emulators.usb.socket_backend import SocketBackend
from sim_backend.emulators.usb.usb_server import UsbServer
from sim_backend.emulators.usb.usbtmc import UsbIdentity, UsbTmcDevice
from sim_backend.emulators.wire_faults import WireFault, WireFaults
from tests.kit.simulated_bench import Bench

IDENTITY = UsbIdentity(0x1209, 0x0D0D, "A17")


@pytest.fixture
def lab():
    class Lab:
        bench = Bench(None)
        faults = WireFaults(1, "amplifier", bench.backend.world)

    lab = Lab()
    lab.device = UsbTmcDevice(IDENTITY, AmplifierScpi(lab.bench.backend.world, IDENTITY.serial))
    lab.server = UsbServer(lab.device, "127.0.0.1", 0, lab.faults)
    lab.backend = SocketBackend("127.0.0.1", lab.server.port)
    yield lab
    lab.server.close()


def opened(lab):
    device = usb.core.find(backend=lab.backend, idVendor=0x1209, idProduct=0x0D0D)
    device.set_configuration()
    usb.util.claim_interface(device, 0)
    return device


def say(device, text, tag=1, timeout=500):
    data = text.encode() + b"\n"
    head = struct.pack("<BBBBIB3x", 1, tag, tag ^ 0xFF, 0, len(data), 1)
    device.write(1, head + data + bytes(-len(data) % 4), timeout)


def hear(device, tag=2, room=1000, timeout=500):
    device.write(1, struct.pack("<BBBBIB3x", 2, tag, tag ^ 0xFF, 0, room, 0), timeout)
    raw = bytes(device.read(0x82, 4096, timeout))
    kind, back, inverse, _, size, attributes = struct.unpack_from("<BBBBIB", raw)
    assert (kind, back, inverse) == (2, tag, tag ^ 0xFF)
    return raw[12 : 12 + size].decode(), bool(attributes & 1)


def ask(device, text):
    say(device, text)
    return hear(device)[0].rstrip("\n")


def test_a_usbtmc_device_is_found_by_its_numbers_and_tells_its_strings(lab):
    device = usb.core.find(backend=lab.backend, idVendor=0x1209)
    assert usb.core.find(backend=lab.backend, idVendor=0x1234) is None
    assert usb.util.get_string(device, device.iSerialNumber) == "A17"
    interface = device[0][(0, 0)]
    assert (interface.bInterfaceClass, interface.bInterfaceSubClass, interface.bInterfaceProtocol) == (0xFE, 3, 1)
    assert [e.bEndpointAddress for e in interface] == [0x01, 0x82]


def test_queries_are_answered_in_short_and_long_form_and_any_case(lab):
    device = opened(lab)
    assert ask(device, "*IDN?").split(",")[2] == "A17"
    assert ask(device, "OUTP?") == ask(device, "output?") == "0"
    assert ask(device, "stat:fault?") == '0,"none"'
    assert 15 < float(ask(device, "SYST:TEMP?")) < 30
    assert ask(device, "OUTP?;:STAT:CLIP?") == "0;0"


def test_output_and_mute_act_on_the_amplifier_in_the_world(lab):
    device, power = opened(lab), lab.bench.backend.world.power
    say(device, "OUTP ON")
    assert (power.enabled, power.muted) == (True, True)
    say(device, "OUTP:MUTE OFF")
    assert (ask(device, "OUTP?"), ask(device, "OUTP:MUTE?"), power.muted) == ("1", "0", False)
    say(device, "OUTP OFF")
    assert (power.enabled, power.muted) == (False, True)


def test_a_latched_fault_keeps_the_output_off_and_says_why(lab):
    device, world = opened(lab), lab.bench.backend.world
    world.power.trip(world.clock.monotonic_s(), "over-current")
    say(device, "OUTP ON")
    assert ask(device, "OUTP?") == "0"
    assert ask(device, "SYST:ERR?") == '-200,"fault latched"'
    assert ask(device, "SYST:ERR?") == '0,"No error"'
    assert ask(device, "STAT:FAULT?") == '2,"over-current"'
    say(device, "STAT:FAULT:RES")
    assert ask(device, "STAT:FAULT?") == '0,"none"'


def test_what_it_does_not_know_goes_into_the_error_queue_and_is_not_answered(lab):
    device = opened(lab)
    say(device, "FROBNICATE?")
    with pytest.raises(usb.core.USBTimeoutError):
        hear(device, timeout=50)
    say(device, "OUTP MAYBE")
    assert ask(device, "SYST:ERR?").startswith("-113")
    assert ask(device, "SYST:ERR?").startswith("-224")


def test_a_long_answer_comes_in_parts_and_a_long_message_goes_in_parts(lab):
    device = opened(lab)
    say(device, "*IDN?")
    head, ended = hear(device, room=10)
    tail, last = hear(device, tag=3)
    assert not ended
    assert last
    assert (head + tail).startswith("Simulated,class-D")
    text = b"*IDN?;" * 100 + b"*IDN?\n"
    frame = struct.pack("<BBBBIB3x", 1, 7, 7 ^ 0xFF, 0, len(text), 1) + text
    device.write(1, frame[:512])
    device.write(1, frame[512:])
    assert hear(device, room=10_000)[0].count("A17") == 101


def test_a_message_that_is_no_usbtmc_stalls_and_clear_recovers(lab):
    device = opened(lab)
    with pytest.raises(usb.core.USBError) as caught:
        device.write(1, b"\x01\x01\x01\x00" + bytes(8))
    assert caught.value.errno == errno.EPIPE
    assert device.ctrl_transfer(0xA1, 5, 0, 0, 1) == array("B", [1])
    assert device.ctrl_transfer(0xA1, 6, 0, 0, 2) == array("B", [1, 0])
    assert device.ctrl_transfer(0xA1, 7, 0, 0, 24)[0] == 1
    assert ask(device, "OUTP?") == "0"


def test_an_aborted_read_ends_with_a_short_packet_and_one_that_is_not_under_way_is_refused(lab):
    device = opened(lab)
    say(device, "FROBNICATE?")
    device.write(1, struct.pack("<BBBBIB3x", 2, 9, 9 ^ 0xFF, 0, 1000, 0))
    assert list(device.ctrl_transfer(0xA2, 3, 8, 0x82, 2)) == [0x81, 8]  # another tag
    assert list(device.ctrl_transfer(0xA2, 3, 9, 0x82, 2)) == [1, 9]
    assert len(device.read(0x82, 512, 500)) == 0
    assert device.ctrl_transfer(0xA2, 4, 0, 0x82, 8)[0] == 1
    assert list(device.ctrl_transfer(0xA2, 3, 9, 0x82, 2)) == [0x81, 9]
    assert ask(device, "OUTP?") == "0"


def test_an_aborted_message_is_forgotten(lab):
    device = opened(lab)
    device.write(1, struct.pack("<BBBBIB3x", 1, 5, 5 ^ 0xFF, 0, 100, 1) + b"OUTP ON")
    assert list(device.ctrl_transfer(0xA2, 1, 5, 0x01, 2)) == [1, 5]
    assert device.ctrl_transfer(0xA2, 2, 0, 0x01, 8)[0] == 1
    assert ask(device, "OUTP?") == "0"


def test_the_drivers_wire_gives_up_without_aborting_and_clears_the_device_when_it_opens(lab):
    asked = []
    control = lab.device.control
    lab.device.control = lambda kind, request, *rest: asked.append((kind, request)) or control(kind, request, *rest)
    address = {"host": "127.0.0.1", "port": lab.server.port}
    table = AmplifierTable(transport="usb", vendor_id=0x1209, product_id=0x0D0D, socket=address, timeout_s=0.1)
    wire = UsbWire(table)
    assert (0xA1, 5) in asked
    wire.send("FROBNICATE?")
    with pytest.raises(DeviceTimeout):
        wire.receive()
    wire.close()
    assert not [request for kind, request in asked if kind == 0xA2]  # nothing to an endpoint
    wire = UsbWire(table)
    wire.send("OUTP?")
    assert wire.receive() == "0"
    wire.close()


def test_two_programs_cannot_hold_the_device_at_once(lab):
    first = opened(lab)
    second = usb.core.find(backend=lab.backend)
    with pytest.raises(usb.core.USBError) as caught:
        usb.util.claim_interface(second, 0)
    assert caught.value.errno == errno.EBUSY
    usb.util.dispose_resources(first)
    usb.util.claim_interface(second, 0)


def test_nothing_is_found_where_nothing_listens_and_a_device_that_goes_is_gone(lab):
    device = opened(lab)
    lab.server.close()
    assert usb.core.find(backend=SocketBackend("127.0.0.1", lab.server.port)) is None
    with pytest.raises(usb.core.USBError) as caught:
        ask(device, "*IDN?")
    assert caught.value.errno == errno.ENODEV


def heard(device):
    """What a careless reader makes of the raw bytes, or the name of the error."""
    say(device, "*IDN?")
    try:
        device.write(1, struct.pack("<BBBBIB3x", 2, 2, 0xFD, 0, 1000, 0), 50)
        raw = bytes(device.read(0x82, 4096, 50))
        return raw[12 : 12 + raw[4]].decode("latin1").rstrip()
    except usb.core.USBError as error:
        return type(error).__name__


@pytest.mark.parametrize("kind", ["timeout", "half_reply", "garbage", "disconnect"])
def test_faults_of_the_wire_strike_one_answer(lab, kind):
    device = opened(lab)
    good = ask(device, "*IDN?")
    lab.faults.arm(WireFault(kind=kind, device="amplifier", at_byte=5))
    assert heard(device) != good
    if kind == "disconnect":
        with pytest.raises(usb.core.USBError):
            say(device, "*CLS")
        device = opened(lab)
    device.ctrl_transfer(0xA1, 5, 0, 0, 1)
    assert ask(device, "*IDN?") == good
