"""What the tests of this room share: an emulated lab in fast motion, and a plain client of the card's server."""

from __future__ import annotations

import json
import socket
import struct
import time
import tomllib
from typing import Any

import numpy as np

from sim_backend.emulators.emulator import LabEmulator
from tests.kit.data import CONFIG
from tests.kit.simulated_bench import QUIET, options

LAB = CONFIG / "emulators" / "lab.toml"
RECORD = struct.Struct("<BQQ4B")
RATE = 125e6 / 2048
SPEED = 10.0


def tables(*, quiet: bool = True, **changes: Any) -> dict[str, Any]:
    """The shipped lab, faster, with the world's changes (dotted paths with __) in it."""
    out = tomllib.loads(LAB.read_text()) | {"speed": SPEED}
    del out["platform"]
    out["world"] = options(**((QUIET if quiet else {}) | changes))
    out["world"]["card"]["adc_bits"] = 16
    for board in out["io_cards"]["boards"]:
        board["ending_s"] = board["memory_access_s"] = 0.0  # plain clients come and go at once
    return out


def lab(**changes: Any) -> LabEmulator:
    return LabEmulator(tables(**changes), LAB.parent)


class Client:
    """One connection of both sockets, and nothing clever."""

    def __init__(self, host: str, command_port: int, data_port: int, timeout_s: float = 5.0) -> None:
        self.data = socket.create_connection((host, data_port), timeout=timeout_s)
        self.command = socket.create_connection((host, command_port), timeout=timeout_s)
        for link in (self.command, self.data):
            link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._buffer = b""

    def send(self, text: str) -> None:
        self.command.sendall(text.encode() + b"\n")

    def line(self) -> str:
        while b"\n" not in self._buffer:
            self.command.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)  # the server holds back the next piece
            part = self.command.recv(4096)
            if not part:
                raise EOFError
            self._buffer += part
        line, _, self._buffer = self._buffer.partition(b"\n")
        assert line.endswith(b"\r")
        return line[:-1].decode()

    def ask(self, text: str) -> str:
        self.send(text)
        return self.line()

    def silent(self, text: str, wait_s: float = 0.1) -> bool:
        """True if nothing is answered; a later answer would show up as that of the next question."""
        self.send(text)
        self.command.settimeout(wait_s)
        try:
            self._buffer += self.command.recv(4096)
            return False
        except TimeoutError:
            return True
        finally:
            self.command.settimeout(5.0)

    def do(self, *commands: str) -> None:
        for command in commands:
            assert self.ask(command) == "1", command

    def receive(self, count: int) -> bytes:
        out = b""
        while len(out) < count:
            self.data.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
            part = self.data.recv(min(count - len(out), 1 << 16))
            if not part:
                raise EOFError
            out += part
        return out

    def upload(self, command: str, values: Any, kind: str = "<f4") -> str:
        self.send(command)
        self.data.sendall(np.ascontiguousarray(values, dtype=kind).tobytes())
        return self.line()

    def pipelined(self, start: int, count: int, chunk: int = 610) -> tuple[np.ndarray, list[tuple[int, ...]]]:
        """(n, 2) codes and the records."""
        assert self.ask(f"RP:ADC:DATA:PIPELINED? {start},{count},{chunk}") == "1"
        parts, records, left = [], [], count
        while left:
            n = min(chunk, left)
            parts.append(np.frombuffer(self.receive(4 * n), "<i2").reshape(-1, 2))
            records.append(RECORD.unpack(self.receive(21)))
            left -= n
        return np.concatenate(parts), records

    def close(self) -> None:
        self.command.close()
        self.data.close()


def connect(emulator: LabEmulator, card: int = 0) -> Client:
    at = emulator.endpoints()["io_cards"][card]
    return Client(at["host"], at["command_port"], at["data_port"])


def configure(client: Client, decimation: int = 2048) -> None:
    """A known state, whatever was before."""
    if client.ask("RP:MODE?") == '"ACQUISITION"':
        client.do("RP:TRIGGER OFF", "RP:MODE CONFIGURATION")
    client.do("RP:ADC:FIRENABLED ON", f"RP:ADC:DECIMATION {decimation}", "RP:TRIGGER:MODE INTERNAL")


def program(client: Client, step: int, values: Any, enable: Any = None, repetitions: int = 1) -> None:
    """Upload a sequence of shape (steps, channels) and set it."""
    values = np.asarray(values, dtype=float)
    client.do(f"RP:DAC:SEQ:SAMPLESPERSTEP {step}", f"RP:DAC:SEQ:CHAN {values.shape[1]}")
    assert client.upload(f"RP:DAC:SEQ:LUT {len(values)},{repetitions}", values) == "1"
    if enable is not None:
        assert client.upload("RP:DAC:SEQ:LUT:ENABLE", enable, "u1") == "1"
    client.do("RP:DAC:SEQ:SET")


def tone(client: Client, frequency_hz: float, amplitude_v: float, channel: int = 0) -> None:
    head = f"RP:DAC:CH{channel}:COMP0"
    client.do(f"{head}:FREQ {frequency_hz}", f"{head}:AMP {amplitude_v}")


def start(client: Client) -> None:
    client.do("RP:MODE ACQUISITION", "RP:TRIGGER ON")


def control(emulator: LabEmulator, do: str, **more: Any) -> Any:
    """One request through the tests' door."""
    at = emulator.endpoints()["control"]
    with socket.create_connection((at["host"], at["port"]), timeout=10) as link:
        link.sendall(json.dumps({"do": do, **more}).encode() + b"\n")
        answer = json.loads(link.makefile().readline())
    assert answer["ok"], answer
    return answer["result"]


def until(condition: Any, within_s: float = 5.0) -> None:
    """Wait for something that other threads do."""
    end = time.monotonic() + within_s
    while not condition():
        assert time.monotonic() < end, "never happened"
        time.sleep(0.002)
