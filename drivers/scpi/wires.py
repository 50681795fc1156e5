"""Wires for SCPI: USBTMC (framing by pyvisa-py, transfers by pyusb) and TCP."""

from __future__ import annotations

import contextlib
import errno
import socket
import warnings
from typing import Any

import usb.core
from pyvisa_py.protocols.usbtmc import USBTMC

from drivers.errors import DeviceDenied, DeviceError, DeviceLost, DeviceNotFound, DeviceProtocolError, DeviceTimeout
from drivers.exchange import Wire
from drivers.scpi.options import DeviceTable
from drivers.serial_line.wire import SerialWire
from drivers.usb.socket_backend import SocketBackend

LONGEST = 4096

# The library warns of a garbled message and goes on; what it makes of it is refused here as garbage.
warnings.filterwarnings("ignore", message="Unexpected MsgID", category=UserWarning)


def open_wire(table: DeviceTable) -> Wire:
    """The wire that a table asks for.  Raises DeviceNotFound, DeviceDenied, DeviceProtocolError."""
    if table.transport == "serial":
        assert table.port is not None
        return SerialWire(table.port, table.baud, table.timeout_s, table.line_end)
    if table.transport == "tcp":
        assert table.host is not None
        return TcpWire(table.host, table.tcp_port, table.timeout_s, table.line_end)
    return UsbWire(table)


class UsbWire:
    """See drivers.exchange.Wire; a USBTMC device."""

    def __init__(self, table: DeviceTable) -> None:
        self._where = f"USB {table.vendor_id:04x}:{table.product_id:04x} {table.serial or ''}".strip()
        self._timeout_s = table.timeout_s
        # pyusb looks for libusb itself if it is given no back end of its own.
        backend = None if table.socket is None else SocketBackend(table.socket.host, table.socket.port)
        timeout_ms = round(table.timeout_s * 1e3)
        try:
            self._device = USBTMC(
                table.vendor_id,
                table.product_id,
                table.serial,
                device_filters={"backend": backend} if backend else {},
                timeout=timeout_ms,
            )
            self._device.usb_dev.default_timeout = timeout_ms
        except Exception as error:  # the library raises ValueError, Exception and USBError
            raise _opening_failed(self._where, error) from None

    def send(self, text: str) -> None:
        """See Wire."""
        try:
            self._device.write(f"{text}\n".encode("ascii"))
        except (ValueError, usb.core.USBError) as error:
            raise self._failed(error) from None

    def receive(self) -> str:
        """See Wire."""
        try:
            raw = self._device.read(LONGEST)
        except (ValueError, usb.core.USBError, IndexError) as error:
            raise self._failed(error) from None
        except Exception as error:  # struct.error of a message cut short
            raise DeviceProtocolError("the answer is no USBTMC message", where=self._where, why=str(error)) from None
        return readable(raw, self._where)

    def close(self) -> None:
        """See Wire."""
        with contextlib.suppress(usb.core.USBError, OSError):
            self._device.close()

    def _failed(self, error: Exception) -> DeviceError:
        if isinstance(error, usb.core.USBTimeoutError) or "timed out" in str(error).lower():
            why = f"none within {self._timeout_s:g} s"
            return DeviceTimeout("no answer", where=self._where, why=why, remedy="check the device")
        return DeviceLost("the USB device is gone", where=self._where, why=str(error), remedy="check cable and power")


class TcpWire:
    """See drivers.exchange.Wire; SCPI on a TCP port."""

    def __init__(self, host: str, port: int, timeout_s: float, end: str = "\n") -> None:
        self._where, self._timeout_s, self._end = f"{host}:{port}", timeout_s, end.encode("ascii")
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


def readable(raw: bytes, where: str) -> str:
    """A line of ASCII.  Raises DeviceProtocolError for an empty one and for garbage."""
    text = raw.decode("ascii", "replace").strip()
    if not text or not text.isprintable() or "\ufffd" in text:
        raise DeviceProtocolError("the answer is garbage", where=where, why=f"it is {raw[:40]!r}")
    return text


def _opening_failed(where: str, error: Any) -> DeviceError:
    """What it means that a USB device cannot be opened."""
    number, text = getattr(error, "errno", None), str(error)
    if number == errno.EACCES or "Access denied" in text or "insufficient permissions" in text.lower():
        remedy = "install the udev rule of docs/wiring.md"
        return DeviceDenied("the USB device may not be opened", where=where, why="permission denied", remedy=remedy)
    if number == errno.EBUSY or "Resource busy" in text:
        return DeviceDenied("another program uses the USB device", where=where, why=text, remedy="stop it")
    if "No backend available" in text:
        return DeviceNotFound("libusb is not installed", where=where, remedy="install libusb-1.0")
    remedy = "check cable and power, and the identifiers in the platform file"
    return DeviceNotFound("there is no such USB device", where=where, why=" ".join(text.split()), remedy=remedy)
