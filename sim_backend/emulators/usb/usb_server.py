"""The socket that an emulated USB device listens on; frames.py says what travels over it."""

from __future__ import annotations

import errno
import socket
import threading
import time

from ..listening import Listener
from ..wire_faults import Hangup, WireFaults
from .frames import REPLY, REQUEST, SETUP, Op, receive
from .usbtmc import Stall, UsbTmcDevice, message_text

POLL_S = 1e-3


class UsbServer:
    """Serves one device to any number of connections; only the one that has claimed the interface may use the bulk
    endpoints."""

    def __init__(self, device: UsbTmcDevice, host: str, port: int, faults: WireFaults) -> None:
        self._device = device
        self._faults = faults
        self._lock = threading.Lock()
        self._owner: socket.socket | None = None
        self._last_command = ""
        self._listener = Listener(host, port, self._serve, "usb")
        self.port = self._listener.port

    def close(self) -> None:
        """Stop listening and cut all connections."""
        self._listener.close()

    def _serve(self, link: socket.socket) -> None:
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        try:
            while True:
                op, endpoint, _, timeout_ms, length = REQUEST.unpack(receive(link, REQUEST.size))
                data = b"" if op == Op.IN else receive(link, length)
                status, answer = self._transfer(link, op, endpoint, data, length, timeout_ms)
                link.sendall(REPLY.pack(status, len(answer)) + answer)
        except Hangup:
            self._device.clear()
        except OSError:
            pass
        finally:
            with self._lock:
                self._owner = None if self._owner is link else self._owner

    def _transfer(
        self, link: socket.socket, op: int, endpoint: int, data: bytes, room: int, timeout_ms: int
    ) -> tuple[int, bytes]:
        """Status (errno or 0) and answer of one transfer.  Raises Hangup, OSError if the device goes away."""
        try:
            if op == Op.IN:
                return self._read(link, endpoint, room, timeout_ms)
            with self._lock:
                return 0, self._now(link, op, endpoint, data)
        except Stall as refusal:
            return refusal.errno, b""

    def _now(self, link: socket.socket, op: int, endpoint: int, data: bytes) -> bytes:
        if op == Op.CONTROL:
            return self._device.control(*SETUP.unpack_from(data))
        if op == Op.CLAIM and self._owner in (None, link):
            self._owner = link
        elif op == Op.CLAIM:
            raise Stall(errno.EBUSY)
        elif op == Op.RELEASE and self._owner is link:
            self._owner = None
        elif op == Op.OUT:
            self._check_owner(link)
            self._last_command = message_text(data) or self._last_command
            if self._faults.hears(self._last_command):
                self._device.bulk_out(endpoint, data)
        elif op == Op.RESET:
            self._device.clear()
        return b""

    def _read(self, link: socket.socket, endpoint: int, room: int, timeout_ms: int) -> tuple[int, bytes]:
        end_s = time.monotonic() + timeout_ms / 1e3 if timeout_ms else float("inf")
        while time.monotonic() < end_s:
            with self._lock:
                self._check_owner(link)
                answer = self._device.bulk_in(endpoint, room)
            if answer == b"":  # a short packet, which ends a transfer
                return 0, answer
            if answer and (answer := self._faults.outgoing(answer, command=self._last_command)):
                return 0, answer
            time.sleep(POLL_S)
        return errno.ETIMEDOUT, b""

    def _check_owner(self, link: socket.socket) -> None:
        if self._owner is not link:
            raise Stall(errno.EBUSY if self._owner is not None else errno.EACCES)
