"""A pyusb back end whose only bus is a TCP socket: USB has no loopback wire, so an emulated device listens on one.

    device = usb.core.find(backend=SocketBackend("127.0.0.1", 40123), idVendor=0x1209)

Everything above pyusb is the same as with real hardware, where its own libusb back end is used.  Each opened device
has its own connection, and claiming an interface that another connection holds fails with EBUSY, as with libusb.
"""

from __future__ import annotations

import errno
import os
import socket
import threading
from array import array
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import usb.backend
import usb.core

from . import descriptors
from .frames import REPLY, REQUEST, SETUP, Op, receive

CONNECT_S = 2.0
GRACE_S = 2.0  # an answer may come this much later than the time-out that was sent to the device
GET_DESCRIPTOR = 6
SET_CONFIGURATION = 9
GET_CONFIGURATION = 8
SET_INTERFACE = 11


class Link:
    """One connection to the device.  Any thread may use it; transfers are made one after the other."""

    def __init__(self, host: str, port: int) -> None:
        self._lock = threading.Lock()
        try:
            self._socket = socket.create_connection((host, port), timeout=CONNECT_S)
        except OSError as error:
            raise usb.core.USBError(f"No such device ({error})", None, errno.ENODEV) from None
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def transfer(self, op: Op, endpoint: int, data: bytes, room: int, timeout_ms: int) -> bytes:
        """One transfer; `room` is the most an IN may bring.  Raises usb.core.USBError, USBTimeoutError."""
        length = room if op is Op.IN else len(data)
        with self._lock:
            try:
                self._socket.settimeout(timeout_ms / 1e3 + GRACE_S if timeout_ms else None)
                self._socket.sendall(REQUEST.pack(op, endpoint, 0, timeout_ms, length) + data)
                status, count = REPLY.unpack(receive(self._socket, REPLY.size))
                answer = receive(self._socket, count)
            except TimeoutError:
                self._socket.close()  # a late answer must not be taken for that of the next transfer
                raise usb.core.USBTimeoutError("Operation timed out", None, errno.ETIMEDOUT) from None
            except OSError:
                self._socket.close()
                raise usb.core.USBError("No such device (it may have been disconnected)", None, errno.ENODEV) from None
        if status == errno.ETIMEDOUT:
            raise usb.core.USBTimeoutError("Operation timed out", None, status)
        if status:
            raise usb.core.USBError(os.strerror(status), None, status)
        return answer

    def control(self, setup: tuple[int, int, int, int, int], data: bytes = b"", timeout_ms: int = 1000) -> bytes:
        """One control transfer; setup is (bmRequestType, bRequest, wValue, wIndex, wLength)."""
        return self.transfer(Op.CONTROL, 0, SETUP.pack(*setup) + data, 0, timeout_ms)

    def close(self) -> None:
        """Let go."""
        self._socket.close()


class Remote:
    """A device on the socket: its address and its descriptors."""

    def __init__(self, host: str, port: int) -> None:
        self.host = host
        self.port = port
        link = self.connect()
        try:
            self.device = descriptors.device_descriptor(_descriptor(link, descriptors.DEVICE, 0, 18))
            self.configurations = [_configuration(link, k) for k in range(self.device.bNumConfigurations)]
        except ValueError as error:
            raise usb.core.USBError(f"Input/output error ({error})", None, errno.EIO) from None
        finally:
            link.close()

    def connect(self) -> Link:
        """A connection to it."""
        return Link(self.host, self.port)


def _descriptor(link: Link, kind: int, index: int, size: int) -> bytes:
    return link.control((0x80, GET_DESCRIPTOR, kind << 8 | index, 0, size))


def _configuration(link: Link, index: int) -> descriptors.Configuration:
    head = _descriptor(link, descriptors.CONFIGURATION, index, 9)
    if len(head) < 4:
        raise ValueError("a configuration descriptor is cut short")
    total = int.from_bytes(head[2:4], "little")
    return descriptors.configuration(_descriptor(link, descriptors.CONFIGURATION, index, total))


class SocketBackend(usb.backend.IBackend):
    """See usb.backend.IBackend, which documents every method."""

    def __init__(self, host: str, port: int) -> None:
        self._host = host
        self._port = port

    def enumerate_devices(self) -> Iterator[Remote]:
        """The one device, or none if nothing listens."""
        try:
            yield Remote(self._host, self._port)
        except usb.core.USBError as error:
            if error.errno != errno.ENODEV:
                raise

    def get_device_descriptor(self, dev: Remote) -> SimpleNamespace:
        """See IBackend."""
        return dev.device

    def get_configuration_descriptor(self, dev: Remote, config: int) -> SimpleNamespace:
        """See IBackend."""
        return dev.configurations[config].descriptor

    def get_interface_descriptor(self, dev: Remote, intf: int, alt: int, config: int) -> SimpleNamespace:
        """See IBackend; there are no alternate settings."""
        if alt:
            raise IndexError("no alternate setting")
        return dev.configurations[config].interfaces[intf].descriptor

    def get_endpoint_descriptor(self, dev: Remote, ep: int, intf: int, alt: int, config: int) -> SimpleNamespace:
        """See IBackend."""
        return dev.configurations[config].interfaces[intf].endpoints[ep]

    def open_device(self, dev: Remote) -> Link:
        """See IBackend."""
        return dev.connect()

    def close_device(self, dev_handle: Link) -> None:
        """See IBackend."""
        dev_handle.close()

    def set_configuration(self, dev_handle: Link, config_value: int) -> None:
        """See IBackend."""
        dev_handle.control((0x00, SET_CONFIGURATION, config_value, 0, 0))

    def get_configuration(self, dev_handle: Link) -> int:
        """See IBackend."""
        return dev_handle.control((0x80, GET_CONFIGURATION, 0, 0, 1))[0]

    def set_interface_altsetting(self, dev_handle: Link, intf: int, altsetting: int) -> None:
        """See IBackend."""
        dev_handle.control((0x01, SET_INTERFACE, altsetting, intf, 0))

    def claim_interface(self, dev_handle: Link, intf: int) -> None:
        """See IBackend.  Raises USBError EBUSY if another program holds it."""
        dev_handle.transfer(Op.CLAIM, intf, b"", 0, 1000)

    def release_interface(self, dev_handle: Link, intf: int) -> None:
        """See IBackend."""
        dev_handle.transfer(Op.RELEASE, intf, b"", 0, 1000)

    def bulk_write(self, dev_handle: Link, ep: int, intf: int, data: array[int], timeout: int) -> int:
        """See IBackend."""
        dev_handle.transfer(Op.OUT, ep, data.tobytes(), 0, timeout)
        return len(data)

    def bulk_read(self, dev_handle: Link, ep: int, intf: int, buff: array[int], timeout: int) -> int:
        """See IBackend."""
        answer = dev_handle.transfer(Op.IN, ep, b"", len(buff), timeout)
        buff[: len(answer)] = array("B", answer)
        return len(answer)

    intr_write = bulk_write
    intr_read = bulk_read

    def ctrl_transfer(
        self,
        dev_handle: Link,
        bmRequestType: int,
        bRequest: int,
        wValue: int,
        wIndex: int,
        data: array[int],
        timeout: int,
    ) -> int:
        """See IBackend; `data` is read or filled, by the direction bit."""
        setup = (bmRequestType, bRequest, wValue, wIndex, len(data))
        if not bmRequestType & 0x80:
            dev_handle.control(setup, data.tobytes(), timeout)
            return len(data)
        answer = dev_handle.control(setup, b"", timeout)[: len(data)]
        data[: len(answer)] = array("B", answer)
        return len(answer)

    def clear_halt(self, dev_handle: Link, ep: int) -> None:
        """See IBackend."""
        dev_handle.control((0x02, 1, 0, ep, 0))

    def reset_device(self, dev_handle: Link) -> None:
        """See IBackend."""
        dev_handle.transfer(Op.RESET, 0, b"", 0, 1000)

    def is_kernel_driver_active(self, dev_handle: Link, intf: int) -> bool:
        """There is no kernel here."""
        return False

    def detach_kernel_driver(self, dev_handle: Link, intf: int) -> Any:
        """Nothing to do."""

    attach_kernel_driver = detach_kernel_driver
