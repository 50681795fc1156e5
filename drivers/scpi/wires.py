"""Wires for SCPI: TCP here, USBTMC in usb_wire.py, serial lines in drivers.serial_line."""

from __future__ import annotations

import select
import socket

from drivers.errors import DeviceLost, DeviceNotFound, DeviceTimeout
from drivers.exchange import Wire
from drivers.scpi.lines import readable
from drivers.scpi.options import DeviceTable
from drivers.scpi.usb_wire import UsbWire
from drivers.serial_line.wire import SerialWire

LONGEST = 4096
GREETING_S = 0.1
"""How long a new connection is waited on for a greeting; one that comes later is taken for an answer, and refused.

A device sends it as soon as it accepts, so it takes one way through the laboratory's network, below 1 ms, and the time
that its firmware needs; a start makes a handful of connections, and each that has no greeting waits so long.
"""


def open_wire(table: DeviceTable) -> Wire:
    """The wire that a table asks for.  Raises DeviceNotFound, DeviceDenied, DeviceProtocolError."""
    if table.transport == "serial":
        assert table.port is not None
        return SerialWire(table.port, table.baud, table.timeout_s, table.line_end)
    if table.transport == "tcp":
        assert table.host is not None
        return TcpWire(table.host, table.tcp_port, table.timeout_s, table.line_end)
    return UsbWire(table)


class TcpWire:
    """See drivers.exchange.Wire; SCPI on a TCP port.

    What arrives unasked, as a greeting or the late answer to an earlier question, is thrown away before a question.
    """

    def __init__(self, host: str, port: int, timeout_s: float, end: str = "\n") -> None:
        self._where = f"{host}:{port}"
        self._timeout_s = timeout_s
        self._end = end.encode("ascii")
        self._received = b""
        try:
            self._socket = socket.create_connection((host, port), timeout_s)
        except OSError as error:
            why = error.strerror or str(error)
            remedy = "check address, power and network"
            raise DeviceNotFound("nothing answers", where=self._where, why=why, remedy=remedy) from None
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        select.select([self._socket], [], [], min(GREETING_S, timeout_s))

    def send(self, text: str) -> None:
        """See Wire."""
        self._received = b""
        try:
            while select.select([self._socket], [], [], 0.0)[0]:
                if not self._socket.recv(LONGEST):
                    raise OSError("the device has closed it")
            self._socket.sendall(text.encode("ascii") + self._end)
        except (OSError, ValueError) as error:  # ValueError: it is closed
            raise self._lost(error) from None

    def receive(self) -> str:
        """See Wire."""
        last = self._end[-1:]
        try:
            while last not in self._received and len(self._received) < LONGEST:
                piece = self._socket.recv(LONGEST)
                if not piece:
                    raise OSError(f"it stopped after {len(self._received)} bytes of an answer")
                self._received += piece
        except TimeoutError:
            why = f"none within {self._timeout_s:g} s"
            raise DeviceTimeout("no answer", where=self._where, why=why, remedy="check the device") from None
        except OSError as error:
            raise self._lost(error) from None
        raw, found, self._received = self._received.partition(last)
        if not found:
            raise self._lost(OSError(f"an answer does not end within {LONGEST} bytes"))
        return readable(raw, self._where)

    def close(self) -> None:
        """See Wire."""
        self._socket.close()

    def _lost(self, error: Exception) -> DeviceLost:
        return DeviceLost("the connection broke", where=self._where, why=str(error), remedy="check device and network")
