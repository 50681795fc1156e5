"""A second RedPitayaDAQServer, written from the protocol's text alone: it shares nothing with the emulator.

One board, one shot after the other, in real time.  What the real server punishes is written down in `mistakes`.
"""

from __future__ import annotations

import contextlib
import re
import socket
import struct
import threading
import time
from typing import Any

import numpy as np

SIMPLE = (  # answered with 1 in any mode and of no further interest here
    r"RP:ADC:FIRENABLED (ON|OFF)|RP:COUNTERTRIGGER:ENABLE OFF|RP:INSTANTRESET:MODE (ON|OFF)"
    r"|RP:DAC:CHANNEL\d:COMPONENT\d:(SIGNALTYPE SINE|FREQUENCY [\d.e+-]+|PHASE [\d.e+-]+)"
    r"|RP:DIO:PIN\d:SIDE[PN]:(DIR|HBRIDGE) \w+"
)
NEEDS_CONFIGURATION = r"RP:(ADC:DECIMATION|TRIGGER:MODE|TRIGGER:PROP|DAC:CHANNEL\d:RAMPING:ENABLE) \w+"


def code(index: np.ndarray, channel: int) -> np.ndarray:
    """What the converter of an input gave at a sample."""
    return (7 * index + 13 * channel) % 2001 - 1000


class ReferenceServer:
    """Listens on two ports; `calibration` is its memory: what CALib queries answer."""

    def __init__(self, calibration: dict[str, float] | None = None, flags: int = 15) -> None:
        self.calibration = {f"{kind}:{k}:{what}": default for kind, what, default in (
            ("ADC", "SCALE", 1 / 32768), ("ADC", "OFFSET", 0.0), ("DAC", "SCALE", 1.0), ("DAC", "OFFSET", 0.0),
            ("DAC", "LIMIT:LOWER", -1.0), ("DAC", "LIMIT:UPPER", 1.0),
        ) for k in (0, 1)} | (calibration or {})  # fmt: skip
        self.calibration = {what: float(np.float32(value)) for what, value in self.calibration.items()}  # as stored
        self.flags, self.image, self.version = flags, 11, 11
        self.mistakes: list[str] = []
        self.log: list[str] = []
        self.amplitude: dict[tuple[str, str], float] = {}
        self.offset: dict[str, float] = {}
        self.played: list[dict[str, Any]] = []
        self.mode, self.decimation, self.channels, self.step = "CONFIGURATION", 16, 0, 0
        self.table: Any = None
        self.left = {"LUT:UP", "LUT:DOWN", "LUT:RESYNC"}  # uploaded by a client before, and never set
        self.sets = 0  # SEQ:SET since the last sequence ended or client came
        self.triggered_at: float | None = None
        self.sending: list[int] | None = None
        self._listeners = [socket.create_server(("127.0.0.1", 0), backlog=1) for _ in range(2)]
        self.ports = tuple(each.getsockname()[1] for each in self._listeners)
        self._closed = False
        self._newcomer: socket.socket | None = None
        threading.Thread(target=self._serve, daemon=True).start()

    def close(self) -> None:
        self._closed = True
        for each in self._listeners:
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()

    # --- clients

    def _serve(self) -> None:
        with contextlib.suppress(OSError):
            while not self._closed:
                command = self._newcomer or self._listeners[0].accept()[0]
                self._newcomer = None
                self.sets, self.sending, self.amplitude = 0, None, {}
                self.mode = "ACQUISITION" if self.mode == "TRANSMISSION" else self.mode
                data = self._listeners[1].accept()[0]
                with contextlib.suppress(OSError), command, data:
                    self._client(command, data)

    def _client(self, command: socket.socket, data: socket.socket) -> None:
        self._data, buffer = data, b""
        self._listeners[0].setblocking(False)
        try:
            while True:
                with contextlib.suppress(BlockingIOError):
                    self._newcomer = self._listeners[0].accept()[0]
                    return  # evicted
                self._end_of_sequence()
                command.settimeout(1e-3)
                with contextlib.suppress(TimeoutError):
                    part = command.recv(32)
                    if not part:
                        return
                    buffer += part
                    continue_reading = len(part) == 32
                    while b"\n" in buffer:
                        line, _, buffer = buffer.partition(b"\n")
                        self._answer(command, line.decode().strip())
                    if continue_reading:
                        continue
                if buffer:
                    self.mistakes.append(f"half a command: {buffer!r}")
                    buffer = b""
                if self.sending is not None:
                    self._chunk()
        finally:
            self._listeners[0].setblocking(True)

    def _answer(self, command: socket.socket, line: str) -> None:
        if not line:
            return
        self.log.append(line)
        reply = self._execute(line)
        if reply is None:
            self.mistakes.append(f"unknown: {line}")
            return
        for piece in re.findall(r".[^,]*", f"{reply}\r\n", re.DOTALL):
            command.sendall(piece.encode())

    # --- time

    def pointer(self) -> int:
        if self.triggered_at is None:
            return 0
        return int((time.monotonic() - self.triggered_at) * 125e6 / self.decimation) // 32 * 32

    def playing(self) -> bool:
        return self.triggered_at is not None and self.sets > 0 and self.pointer() < self.step * len(self.table[0])

    def _end_of_sequence(self) -> None:
        if self.triggered_at is not None and self.sets > 0 and not self.playing():
            self.sets, self.amplitude = 0, {}

    def _chunk(self) -> None:
        assert self.sending is not None
        first, stop, chunk = self.sending
        count = min(chunk, stop - first)
        if self.pointer() < first + count:
            return  # the real one reads no commands meanwhile; ours may, nobody can tell
        lag = self.pointer() - first
        index = np.arange(first, first + count)
        self._data.sendall(np.stack([code(index, 0), code(index, 1)], axis=1).astype("<i2").tobytes())
        status = 8 * (self.triggered_at is not None) + 16 * self.playing()
        self._data.sendall(struct.pack("<BQQ4B", status, lag, 3, 1, 1, 255, 0))
        self.sending = [first + count, stop, chunk] if first + count < stop else None
        if self.sending is None:
            self.mode = "ACQUISITION"

    # --- commands

    def _execute(self, line: str) -> str | None:
        head, _, rest = line.partition(" ")
        if head == "*IDN?":
            return "CUSTOM,REDPITAYA,0,0.1"
        if re.fullmatch(SIMPLE, line):
            return "1"
        if re.fullmatch(NEEDS_CONFIGURATION, line):
            if self.mode != "CONFIGURATION":
                return "-5"
            if head == "RP:ADC:DECIMATION":
                self.decimation = int(rest)
            return "1"
        if found := re.fullmatch(r"RP:CALIB:(ADC|DAC):CHANNEL(\d):(SCALE|OFFSET|LIMIT:LOWER|LIMIT:UPPER)\?", line):
            return f"{self.calibration[':'.join(found.groups())]:.6g}"
        if found := re.fullmatch(r"RP:DAC:CHANNEL(\d):COMPONENT(\d):AMPLITUDE(\?| [\d.e+-]+)", line):
            return self._amplitude(found[1], found[2], found[3])
        if found := re.fullmatch(r"RP:DAC:CHANNEL(\d):OFFSET(\?| [\d.e+-]+)", line):
            if found[2] == "?":
                return f"{self.offset.get(found[1], 0.0):.15g}"
            self.offset[found[1]] = float(found[2])
            return "1"
        if re.fullmatch(r"RP:DIO:PIN\d:SIDE[PN]( ON| OFF|\?)", line):
            return '"OFF"' if line.endswith("?") else "1"
        if head.startswith("RP:DAC:SEQ") or head.startswith("RP:COUNTER:"):
            return self._sequence(head.rpartition("SEQ:")[2], rest) if self.mode == "CONFIGURATION" else "-7"
        return self._server(head, rest)

    def _amplitude(self, channel: str, component: str, what: str) -> str:
        if what == "?":
            register = self.amplitude.get((channel, component), 0.0)
            return f"{register / self.calibration[f'DAC:{channel}:SCALE']:.15g}" if register else "0"
        level = float(what) * self.calibration[f"DAC:{channel}:SCALE"]
        if not 0 <= level <= 1:
            return "-2"
        self.amplitude.pop((channel, component), None)
        if level:
            self.amplitude[channel, component] = int(level * 65534) / 65534
        return "1"

    def _sequence(self, what: str, rest: str) -> str:
        if what == "SAMPLESPERSTEP":
            self.step = int(rest)
        elif what == "CHAN":
            self.channels = int(rest)
        elif what == "LUT":
            steps, repetitions = map(int, rest.split(","))
            values = np.frombuffer(self._upload(4 * steps * self.channels), "<f4").reshape(steps, self.channels)
            self.table = (np.tile(values, (repetitions, 1)), np.ones((steps, self.channels), np.uint8))
        elif what == "LUT:ENABLE":
            raw = self._upload(self.table[0].size)
            self.table = (self.table[0], np.frombuffer(raw, np.uint8).reshape(self.table[0].shape))
        elif what == "LUT:RESYNC":
            self.left.discard(what)
            if any(self._upload(len(self.table[0]) * min(self.channels, 2))):
                self.mistakes.append("a phase is restarted")
        elif what in ("LUT:UP", "LUT:DOWN"):
            self.left.discard(what)
            if rest != "0,0":
                self.mistakes.append(f"{what} {rest}: played before or after the sequence")
        elif what == "SET":
            if self.left:
                self.mistakes.append(f"tables of the client before are played, too: {self.left}")
            self.sets, self.left = self.sets + 1, set()
            if self.sets > 1:
                self.mistakes.append("SEQ:SET twice without a run: the gate is open")
        return "1"

    def _upload(self, count: int) -> bytes:
        raw = b""
        self._data.settimeout(2.0)
        while len(raw) < count:
            raw += self._data.recv(count - len(raw))
        return raw

    def _server(self, head: str, rest: str) -> str | None:
        if head == "RP:TRIGGER":
            return self._trigger(rest)
        if head == "RP:TRIGGER:ALIVE":
            return "1" if self.mode == "ACQUISITION" else "-5"
        if head == "RP:MODE":
            if self.mode == "TRANSMISSION":
                return "-5"
            self.mode = rest
            return "1"
        if head == "RP:ADC:DATA?":
            if self.mode != "ACQUISITION":
                return "-5"
            self._data.sendall(bytes(4 * int(rest.split(",")[1])))
            return "1"
        if head == "RP:ADC:DATA:PIPELINED?":
            if self.mode != "ACQUISITION":
                return "-5"
            start, count, chunk = map(int, rest.split(","))
            self.mode, self.sending = "TRANSMISSION", [start, start + count, chunk]
            return "1"
        answers = {
            "RP:MODE?": f'"{self.mode}"',
            "RP:TRIGGER?": f'"{"OFF" if self.triggered_at is None else "ON"}"',
            "RP:ADC:WP?": str(self.pointer()),
            "RP:ADC:DECIMATION?": str(self.decimation),
            "RP:STATUS?": str(8 * (self.triggered_at is not None) + 16 * self.playing()),
            "RP:VERSION:IMAGE?": str(self.image),
            "RP:VERSION:SERVER?": str(self.version),
            "RP:CALIB:FLAGS": str(self.flags),
            "RP:INSTANTRESET:STATUS?": "0",
            "RP:INSTANTRESET:TRIGGERED?": "0",
        }
        return answers.get(head)

    def _trigger(self, rest: str) -> str:
        if self.mode != "ACQUISITION":
            return "-5"
        if rest == "OFF" and self.playing():
            self.mistakes.append("the trigger went off before the sequence had ended")
        if rest == "ON":
            values, enable = self.table
            self.played.append({"values": values, "enable": enable, "step": self.step, "sines": dict(self.amplitude)})
        self.triggered_at = time.monotonic() if rest == "ON" else None
        return "1"
