"""Wires for SCPI: TCP here, USBTMC in usb_wire.py, serial lines in drivers.serial_line."""

from __future__ import annotations

import socket

from drivers.errors import DeviceLost, DeviceNotFound, DeviceTimeout
from drivers.exchange import Wire
from drivers.scpi.lines import readable
from drivers.scpi.options import DeviceTable
from drivers.scpi.usb_wire import UsbWire
from drivers.serial_line.wire import SerialWire

LONGEST = 4096


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
    """See drivers.exchange.Wire; SCPI on a TCP port."""

    def __init__(self, host: str, port: int, timeout_s: float, end: str = "\n") -> None:
        self._where = f"{host}:{port}"
        self._timeout_s = timeout_s
        self._end = end.encode("ascii")
        try:
            self._socket = socket.create_connection((host, port), timeout_s)
        except OSError as error:
            why = error.strerror or str(error)
            remedy = "check address, power and network"
            raise DeviceNotFound("nothing answers", where=self._where, why=why, remedy=remedy) from None
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._lines = self._socket.makefile("rb")

    def send(self, text: str) -> None:
        """See Wire."""
        try:
            self._socket.sendall(text.encode("ascii") + self._end)
        except OSError as error:
            raise self._lost(error) from None

    def receive(self) -> str:
        """See Wire."""
        raw = b""
        try:
            while len(raw) < LONGEST and not raw.endswith(self._end[-1:]) and (byte := self._lines.read(1)):
                raw += byte
        except TimeoutError:
            why = f"none within {self._timeout_s:g} s"
            raise DeviceTimeout("no answer", where=self._where, why=why, remedy="check the device") from None
        except OSError as error:
            raise self._lost(error) from None
        if not raw.endswith(self._end[-1:]):
            raise self._lost(OSError(f"it stopped after {len(raw)} bytes of an answer"))
        return readable(raw, self._where)

    def close(self) -> None:
        """See Wire."""
        self._lines.close()
        self._socket.close()

    def _lost(self, error: Exception) -> DeviceLost:
        return DeviceLost("the connection broke", where=self._where, why=str(error), remedy="check device and network")
