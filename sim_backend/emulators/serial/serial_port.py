"""A serial device on a pseudo-terminal: lines in, one reply line each out.

The port's path is a link, as udev makes one for the lab's adapters, so that it stays the same when the device is
unplugged and plugged in again.
"""

from __future__ import annotations

import os
import select
import threading
import tty
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from drivers.errors import ConfigError

from ..wire_faults import Hangup, WireFaults

LONGEST_LINE = 1024
UNKNOWN, BAD_ARGUMENT, NOT_NOW, FAULT = (
    'ERR 1,"unknown command"',
    'ERR 2,"bad argument"',
    'ERR 3,"not now"',
    'ERR 4,"fault"',
)


class SerialDevice(Protocol):
    """What answers the lines."""

    def execute(self, line: str) -> str:
        """The reply to one command in capitals, without line end."""


class SerialPort:
    """One pseudo-terminal and the thread that serves it."""

    def __init__(self, link: Path, device: SerialDevice, faults: WireFaults) -> None:
        if link.is_symlink() or link.exists():
            raise ConfigError("exists already", where=str(link), remedy="name another path, or remove it")
        self.link = link
        self._device = device
        self._faults = faults
        self._closing, self._closed = os.pipe()
        self._master = self._slave = -1
        self._plug_in()
        self._thread = threading.Thread(target=self._run, name="serial", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Unplug it for good and remove the link."""
        os.write(self._closed, b"x")
        self._thread.join(timeout=5)
        with suppress(OSError):
            if os.readlink(self.link) == self._target:
                self.link.unlink()
        self._let_go(self._master, self._slave, self._closing, self._closed)

    def _plug_in(self) -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self._target = os.ttyname(self._slave)
        part = self.link.with_name(f".{self.link.name}.{os.getpid()}")
        part.symlink_to(self._target)
        part.replace(self.link)

    def _let_go(self, *ends: int) -> None:
        for end in ends:
            with suppress(OSError):
                os.close(end)

    def _run(self) -> None:
        pending = b""
        while True:
            readable, _, _ = select.select([self._master, self._closing], [], [])
            if self._closing in readable:
                return
            pending += os.read(self._master, LONGEST_LINE)
            *lines, pending = pending.split(b"\n")
            pending = pending[-LONGEST_LINE:]
            try:
                for line in lines:
                    self._answer(line.decode("ascii", "replace").strip())
            except Hangup as fault:
                os.write(self._master, fault.last)
                closed = (self._master, self._slave)
                self._plug_in()
                self._let_go(*closed)
                pending = b""

    def _answer(self, line: str) -> None:
        if line and self._faults.hears(line):
            reply = self._device.execute(line.upper()).encode("ascii") + b"\r\n"
            os.write(self._master, self._faults.outgoing(reply, command=line))
