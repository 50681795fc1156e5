"""What an emulator refuses, and how its world is put together."""

import socket
import tomllib

import pytest

from drivers.errors import ConfigError
from sim_backend.emulators.emulator import LabEmulator
from tests.kit.emulator_client import LAB, control, lab


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (("AO0", "AO9"), "AO9"),
        (("AO0", "DIO5_P"), "DIO5_P"),
        (("board = 0", "board = 2"), "no board 2"),
        (("seed = 1", "sead = 1"), "sead"),
        (("speed = 1.0", "speed = 0.0"), "speed"),
        (("lna_gain = 40.0", "lna_gain = 41.0"), "41"),
        (('kind = "usb"', 'kind = "brick"'), "amplifier.kind"),
        (('kind = "lna"', 'kind = "toaster"'), "serial.lna.kind"),
        (("thread.toml", "nothing.toml"), "nothing.toml"),
        (("platforms/simulated.toml", "resonators/thread.toml"), "backends.simulated"),
        (('["x", "y"]', '["x", "w"]'), "inputs"),
    ],
)
def test_a_bad_file_is_refused_with_the_key(change, word):
    text = LAB.read_text()
    assert change[0] in text
    with pytest.raises(ConfigError, match=word):
        LabEmulator(tomllib.loads(text.replace(*change, 1)), LAB.parent)


def test_a_fault_of_a_device_that_is_not_there_is_refused():
    tables = tomllib.loads(LAB.read_text()) | {"wire_faults": [{"kind": "timeout", "device": "toaster"}]}
    with pytest.raises(Exception, match="toaster"):
        LabEmulator(tables, LAB.parent)


def test_changes_of_the_world_are_merged_into_the_platforms():
    tables = tomllib.loads(LAB.read_text()) | {"world": {"amplifier": {"limit_v": 5.0}}}
    emulator = LabEmulator(tables, LAB.parent)
    assert emulator.world.options.amplifier.limit_v == 5.0
    assert emulator.world.options.amplifier.gain == 10.0
    emulator.close()


def test_an_amplifier_on_a_line_is_always_live_and_no_usb_device():
    tables = tomllib.loads(LAB.read_text()) | {"amplifier": {"kind": "line"}}
    emulator = LabEmulator(tables, LAB.parent)
    assert emulator.endpoints()["usb"] == {}
    outputs = control(emulator, "outputs")
    assert outputs["amplifier_live"]
    assert outputs["off"]
    emulator.close()


def test_another_resonator_can_be_put_in(lab_with):
    emulator = lab_with()
    jewel = tomllib.loads((LAB.parents[1] / "resonators/jewel.toml").read_text())
    control(emulator, "mount", specimen=jewel)
    assert emulator.world.specimen().name == jewel["name"]


def test_closing_twice_is_harmless_and_leaves_no_port_open():
    emulator = lab()
    address = "127.0.0.1", emulator.endpoints()["control"]["port"]
    socket.create_connection(address).close()
    emulator.close()
    emulator.close()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(address)
