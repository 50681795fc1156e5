"""What a lab may find at the other end of its cables: one clear error each, before anything is energised."""

from __future__ import annotations

import contextlib
import math
import socket
import threading
from collections.abc import Callable, Iterator

import pytest

from drivers.errors import DeviceError, DeviceFault, DeviceLost, DeviceProtocolError, DeviceTimeout
from tests.kit.emulated_lab import Lab

PROVE = "io_card.prove_wiring=true"
QUICK = ("io_card.reply_timeout_s=1.0", "io_card.sample_timeout_s=1.0")
Labs = Callable[..., Lab]


def refused(lab: Lab, kind: type[DeviceError], *overrides: str) -> DeviceError:
    """The one error that the platform is refused with: it says what, where, why and what to do; nothing was on."""
    with pytest.raises(kind) as seen:
        lab.platform(PROVE, *QUICK, *overrides)
    error = seen.value
    assert isinstance(error, DeviceError)
    assert error.what
    assert error.where
    assert error.why or error.remedy
    assert error.remedy
    outputs = lab.control("outputs")
    assert outputs["off"]
    assert not outputs["amplifier_live"]
    assert lab.control("power_log") == []
    assert lab.violations() == ()
    return error


def address(lab: Lab, board: int, port: str = "command_port") -> str:
    """Host and port of a card, as errors name them."""
    at = lab.emulator.endpoints()["io_cards"][board]
    return f"{at['host']}:{at[port]}"


def boards(slave: str = "", master: str = "") -> str:
    """The emulated cards, with more keys."""
    first = f'{{inputs=["x","y"], outputs=["x","y"]{master}}}'
    return f'io_cards.boards=[{first}, {{inputs=["z",""], outputs=["z",""]{slave}}}]'


@pytest.mark.parametrize("versions", ["server_version=10", "image_version=12", "server_version=0"])
def test_a_server_or_image_of_another_version(lab_of_its_own: Labs, versions: str) -> None:
    lab = lab_of_its_own(boards(slave=f", {versions}"))
    error = refused(lab, DeviceProtocolError)
    assert error.where == address(lab, 1)
    assert versions.split("=")[1] in error.what
    assert "update" in error.remedy


def test_an_image_that_drives_ao0_only(lab_of_its_own: Labs) -> None:
    error = refused(lab_of_its_own(boards(master=", slow_outputs=1")), DeviceFault)
    assert "does not follow" in error.what
    assert "AO0 only" in str(error)


@pytest.mark.parametrize("board", [0, 1])
@pytest.mark.parametrize("key", [("DAC", 0), ("DAC", 1), ("ADC", 0)])
@pytest.mark.parametrize("scale", [0.0, -0.93, math.nan, 100.0])
def test_a_memory_whose_scale_is_nonsense(lab_of_its_own: Labs, board: int, key: tuple[str, int], scale: float) -> None:
    lab = lab_of_its_own()
    lab.emulator.cards.boards[board].scales[key] = scale
    error = refused(lab, DeviceProtocolError)
    assert error.where == address(lab, board)
    assert f"{key[0]}:CHANNEL{key[1]}:SCALE is {scale}".replace(".0", "") in error.why.replace(".0", "")


@pytest.mark.parametrize("side", ["LOWER", "UPPER"])
def test_a_memory_whose_limits_hold_an_output_at_a_level(lab_of_its_own: Labs, side: str) -> None:
    lab = lab_of_its_own()
    lab.emulator.cards.boards[1].limits[0, side] = 0.4 if side == "LOWER" else -0.4
    error = refused(lab, DeviceProtocolError)
    assert error.where == address(lab, 1)
    assert f"DAC:CHANNEL0:LIMIT:{side} is" in error.why


def test_a_memory_whose_offset_is_a_direct_current(lab_of_its_own: Labs) -> None:
    lab = lab_of_its_own()
    lab.emulator.cards.boards[0].offsets["DAC", 1] = 0.3
    error = refused(lab, DeviceProtocolError)
    assert "DAC:CHANNEL1:OFFSET is 0.3" in error.why


@pytest.mark.long
def test_a_slave_that_answers_late(lab_of_its_own: Labs) -> None:
    lab = lab_of_its_own()
    lab.control("wire_fault", kind="slow_link", device="io_card_1", delay_s=2.0, count=100)
    error = refused(lab, DeviceTimeout)
    assert error.where == address(lab, 1)
    assert "does not answer" in str(error)


def test_a_slave_that_answers_late_once_it_is_connected(lab_of_its_own: Labs) -> None:
    lab = lab_of_its_own()
    lab.control("wire_fault", kind="slow_link", device="io_card_1", command="TRIGGER?", delay_s=2.0, count=100)
    error = refused(lab, DeviceTimeout)
    assert error.where == address(lab, 1)


def test_two_masters(lab_of_its_own: Labs) -> None:
    lab = lab_of_its_own('io_cards.trigger_wire="dio"')  # nothing reaches the second card over the clock cable
    error = refused(lab, DeviceTimeout)
    assert error.where == address(lab, 1)
    assert "wired as a slave" in error.remedy


@contextlib.contextmanager
def program(greeting: bytes) -> Iterator[int]:
    """Another program, on a port of its own; it says so much and reads what comes."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        links: list[socket.socket] = []

        def serve() -> None:
            with contextlib.suppress(OSError):
                while True:
                    links.append(server.accept()[0])
                    links[-1].sendall(greeting)

        thread = threading.Thread(target=serve)
        thread.start()
        yield server.getsockname()[1]
        server.shutdown(socket.SHUT_RDWR)
        thread.join()
        for link in links:
            link.close()


@pytest.mark.parametrize("greeting", [b"SSH-2.0-OpenSSH_9.6\r\n", pytest.param(b"", marks=pytest.mark.long)])
def test_a_data_port_of_another_program(lab_of_its_own: Labs, greeting: bytes) -> None:
    lab = lab_of_its_own('io_cards.boards=[{inputs=["x","y"], outputs=["x","y"]}]')
    one = 'host="${io_cards.0.host}", command_port="${io_cards.0.command_port}"'
    with program(greeting) as port:
        error = refused(lab, DeviceError, f"io_card.boards=[{{{one}, data_port={port}}}]")
    assert str(port) in str(error) or error.where == address(lab, 0)
    assert "data port" in str(error)


def test_a_stranger_that_never_leaves(lab_of_its_own: Labs) -> None:
    """It connects again as soon as it is thrown out."""
    lab = lab_of_its_own()
    at, over = lab.emulator.endpoints()["io_cards"][0], threading.Event()

    def stay() -> None:
        while not over.is_set():
            with contextlib.suppress(OSError), contextlib.ExitStack() as held:
                data = held.enter_context(socket.create_connection((at["host"], at["data_port"]), 1))
                command = held.enter_context(socket.create_connection((at["host"], at["command_port"]), 1))
                command.settimeout(0.5)
                data.settimeout(0.5)
                while not over.is_set():
                    with contextlib.suppress(TimeoutError):
                        if not command.recv(100):
                            break

    thread = threading.Thread(target=stay)
    thread.start()
    try:
        error = refused(lab, DeviceError)
    finally:
        over.set()
        thread.join()
    assert isinstance(error, DeviceLost | DeviceTimeout | DeviceProtocolError)
    assert error.where.startswith(f"{at['host']}:")
    assert "another" in str(error) or "connected" in str(error)
