"""USBTMC: framing by pyvisa-py, transfers by pyusb."""

from __future__ import annotations

import contextlib
import errno
import time
import warnings
from typing import Any

import usb.core
from pyvisa_py.protocols.usbtmc import USBTMC

from drivers import entry_points
from drivers.errors import DeviceDenied, DeviceError, DeviceLost, DeviceNotFound, DeviceProtocolError, DeviceTimeout
from drivers.scpi.lines import readable
from drivers.scpi.options import DeviceTable, SocketTable

LONGEST = 4096
CLASS_IN = 0xA1  # a question to the interface, USBTMC table 15
INITIATE_CLEAR = 5
CHECK_CLEAR_STATUS = 6
PENDING = 2
CLEAR_S = 1.0

# The library warns of a garbled message and continues; what it makes of it is refused here as garbage.
warnings.filterwarnings("ignore", message="Unexpected MsgID", category=UserWarning)


class Device(USBTMC):
    """The session of pyvisa-py without its abort of a failed read, which takes 5 s more: after a failure the wire is
    opened again, and every opening clears the device."""

    def _abort_bulk_in(self, btag: int) -> None:
        """See the class."""

    def clear(self) -> None:
        """Discard partial messages and old answers (USBTMC 4.2.1.6); a device that cannot answers with a stall."""
        interface = self.usb_intf.bInterfaceNumber
        try:
            self.usb_dev.ctrl_transfer(CLASS_IN, INITIATE_CLEAR, 0, interface, 1)
            deadline = time.monotonic() + CLEAR_S
            while time.monotonic() < deadline:
                status, rest = self.usb_dev.ctrl_transfer(CLASS_IN, CHECK_CLEAR_STATUS, 0, interface, 2)
                if status != PENDING:
                    break
                if rest & 1:
                    self.usb_recv_ep.read(self.usb_recv_ep.wMaxPacketSize)
            self.usb_send_ep.clear_halt()
        except usb.core.USBError as refusal:
            if refusal.errno != errno.EPIPE:
                raise


def socket_backend(table: SocketTable) -> Any:
    """The pyusb back end of an emulated device, published as an entry point; for a real device pyusb finds libusb by
    itself.  Raises ConfigError if none is installed."""
    return entry_points.load(entry_points.USB_BACKENDS, "socket", "USB back end")(table.host, table.port)


class UsbWire:
    """See drivers.exchange.Wire; a USBTMC device."""

    def __init__(self, table: DeviceTable) -> None:
        self._where = f"USB {table.vendor_id:04x}:{table.product_id:04x} {table.serial or ''}".strip()
        self._timeout_s = table.timeout_s
        filters = {} if table.socket is None else {"backend": socket_backend(table.socket)}
        timeout_ms = round(table.timeout_s * 1e3)
        try:
            self._device = Device(
                table.vendor_id,
                table.product_id,
                table.serial,
                device_filters=filters,
                timeout=timeout_ms,
            )
            self._device.usb_dev.default_timeout = timeout_ms
            self._device.clear()
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


def _opening_failed(where: str, error: Any) -> DeviceError:
    """What it means that a USB device cannot be opened."""
    number = getattr(error, "errno", None)
    text = str(error)
    if number == errno.EACCES or "Access denied" in text or "insufficient permissions" in text.lower():
        remedy = "install the udev rule of docs/reference/wiring.md"
        return DeviceDenied("the USB device may not be opened", where=where, why="permission denied", remedy=remedy)
    if number == errno.EBUSY or "Resource busy" in text:
        return DeviceDenied("another program uses the USB device", where=where, why=text, remedy="stop it")
    if "No backend available" in text:
        return DeviceNotFound("libusb is not installed", where=where, remedy="install libusb-1.0")
    remedy = "check cable and power, and the identifiers in the platform file"
    return DeviceNotFound("there is no such USB device", where=where, why=" ".join(text.split()), remedy=remedy)
