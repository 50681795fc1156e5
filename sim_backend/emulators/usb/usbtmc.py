"""The device's side of USBTMC 1.0 and its USB488 subclass, over two bulk endpoints: texts in, texts out."""

from __future__ import annotations

import errno
import struct
from dataclasses import dataclass
from typing import Protocol

OUT_ENDPOINT = 0x01
IN_ENDPOINT = 0x82
PACKET = 512
MESSAGE_OUT = 1
REQUEST_IN = 2
HEADER = struct.Struct("<BBBBIB3x")
DONE = 0x01
NOT_IN_PROGRESS = 0x81
GET_STATUS = 0
CLEAR_FEATURE = 1
GET_DESCRIPTOR = 6
GET_CONFIGURATION = 8
SET_CONFIGURATION = 9
SET_INTERFACE = 11
TYPE_MASK = 0x60
CLASS = 0x20
LONGEST_MESSAGE = 1 << 20


class Instrument(Protocol):
    """What a text goes to."""

    def execute(self, line: str) -> str | None:
        """The answer to one line, None: there is none."""


class Stall(Exception):
    """The device refuses a transfer; `errno` is what the host's library will say."""

    def __init__(self, number: int = errno.EPIPE) -> None:
        self.errno = number


@dataclass(frozen=True)
class UsbIdentity:
    """Vendor and product number, serial number and names."""

    vendor_id: int
    product_id: int
    serial: str
    maker: str = "Simulated"
    product: str = "class-D amplifier"


def message_text(data: bytes) -> str:
    """The text in a transfer from the host, empty if it carries none."""
    return data[HEADER.size :].decode("ascii", "replace").strip() if data[:1] == bytes([MESSAGE_OUT]) else ""


class UsbTmcDevice:
    """One USBTMC function.  `control`, `bulk_out` and `bulk_in` are the transfers of the host; one caller at a time."""

    def __init__(self, identity: UsbIdentity, instrument: Instrument) -> None:
        self.identity = identity
        self._instrument = instrument
        self._configured = 0
        self.clear()

    def clear(self) -> None:
        """Discard incomplete messages and answers that were not fetched."""
        self._message = b""
        self._answer = b""
        self._in = b""
        self._expected = 0
        self._tag: int | None = None  # of a request that is not served to its end
        self._cut = False  # an aborted transfer still has to end with a short packet

    # --- bulk

    def bulk_out(self, endpoint: int, data: bytes) -> None:
        """A transfer from the host.  Raises Stall for what is no USBTMC message."""
        if endpoint != OUT_ENDPOINT:
            raise Stall(errno.ENOENT)
        if self._expected > 0:  # a message longer than one transfer
            self._take(data)
            return
        if len(data) < HEADER.size:
            raise Stall
        kind, tag, inverse, _, size, attributes = HEADER.unpack_from(data)
        if tag == 0 or tag ^ inverse != 0xFF or size > LONGEST_MESSAGE:
            raise Stall
        if kind == MESSAGE_OUT:
            self._expected = size
            self._ends = bool(attributes & 1)
            self._take(data[HEADER.size :])
        elif kind == REQUEST_IN:
            self._offer(tag, size)
        else:
            raise Stall

    def _take(self, data: bytes) -> None:
        part = data[: self._expected]
        self._message = self._message + part
        self._expected = self._expected - len(part)
        if self._expected == 0 and self._ends:
            lines = self._message.decode("ascii", "replace").splitlines()
            self._message = b""
            self._answer = b""  # an answer that was not fetched is lost when the next message comes
            for line in lines:
                if (answer := self._instrument.execute(line)) is not None:
                    self._answer += answer.encode("ascii", "replace") + b"\n"

    def _offer(self, tag: int, room: int) -> None:
        self._tag = tag
        if not self._answer:
            return  # the read that follows will time out
        part = self._answer[:room]
        self._answer = self._answer[room:]
        head = HEADER.pack(REQUEST_IN, tag, tag ^ 0xFF, 0, len(part), int(not self._answer))
        self._in = head + part + bytes(-len(part) % 4)

    def bulk_in(self, endpoint: int, room: int) -> bytes | None:
        """What a read of the host gets, None if there is nothing (yet)."""
        if endpoint != IN_ENDPOINT:
            raise Stall(errno.ENOENT)
        if self._cut:
            self._cut = False
            return b""
        if not self._in:
            return None
        part = self._in[:room]
        self._in = self._in[room:]
        self._tag = self._tag if self._in else None
        return part

    # --- control

    def control(self, kind: int, request: int, value: int, index: int, length: int) -> bytes:
        """A control transfer of the host.  Raises Stall for what the device does not know."""
        if kind & TYPE_MASK == CLASS:
            return self._class_request(request, value)[:length]
        if request == GET_DESCRIPTOR:
            return self._descriptor(value >> 8, value & 0xFF)[:length]
        if request == SET_CONFIGURATION and value in (0, 1):
            self._configured = value
            self.clear()
        elif request == GET_CONFIGURATION:
            return bytes([self._configured])
        elif request == GET_STATUS:
            return bytes(2)
        elif request not in (CLEAR_FEATURE, SET_INTERFACE):
            raise Stall
        return b""

    def _class_request(self, request: int, value: int) -> bytes:
        """USBTMC table 15 and USB488 table 9."""
        if request == 5:  # INITIATE_CLEAR
            self.clear()
            return bytes([DONE])
        if request in (1, 3):  # INITIATE_ABORT_BULK_OUT, _IN
            return bytes([self._abort(request, value & 0xFF), value & 0xFF])
        if request in (2, 4):  # CHECK_ABORT_BULK_OUT_STATUS, _IN_STATUS
            return bytes([DONE]) + bytes(7)
        if request == 6:  # CHECK_CLEAR_STATUS
            return bytes([DONE, 0])
        if request == 7:  # GET_CAPABILITIES: USBTMC 1.0, nothing special; USB488 1.0, REN, SCPI
            return bytes([DONE, 0, 0, 1, 0, 0]) + bytes(6) + bytes([0, 1, 6, 8]) + bytes(8)
        if request == 128:  # READ_STATUS_BYTE, bit 4: an answer waits
            return bytes([DONE, value & 0xFF, 0x10 if self._answer else 0])
        if request in (160, 161, 162):  # REN_CONTROL, GO_TO_LOCAL, LOCAL_LOCKOUT
            return bytes([DONE])
        raise Stall

    def _abort(self, request: int, tag: int) -> int:
        """The status; an IN transfer that is aborted ends with a short packet."""
        under_way = self._expected > 0 if request == 1 else self._tag == tag
        if under_way:
            self.clear()
            self._cut = request == 3
        return DONE if under_way else NOT_IN_PROGRESS

    def _descriptor(self, kind: int, index: int) -> bytes:
        if kind == 1:
            numbers = (0x0200, 0, 0, 0, 64, self.identity.vendor_id, self.identity.product_id, 0x0100, 1, 2, 3, 1)
            return struct.pack("<BBHBBBBHHHBBBB", 18, 1, *numbers)
        if kind == 2 and index == 0:
            interface = struct.pack("<9B", 9, 4, 0, 0, 2, 0xFE, 3, 1, 0)
            ends = b"".join(struct.pack("<BBBBHB", 7, 5, e, 2, PACKET, 0) for e in (OUT_ENDPOINT, IN_ENDPOINT))
            body = interface + ends
            return struct.pack("<BBHBBBBB", 9, 2, 9 + len(body), 1, 1, 0, 0xC0, 0) + body
        if kind == 3:
            names = (self.identity.maker, self.identity.product, self.identity.serial)
            if index == 0:
                return bytes([4, 3, 0x09, 0x04])
            if index <= len(names):
                text = names[index - 1].encode("utf-16-le")
                return bytes([2 + len(text), 3]) + text
        raise Stall
