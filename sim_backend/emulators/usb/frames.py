"""What travels over the socket between `socket_backend` and an emulated USB device: one frame per transfer.

Request: op (u8), endpoint (u8), 0 (u16), time-out ms (u32), length (u32), all big-endian; then `length` bytes, except
for IN, where `length` is the room for the answer.  CONTROL carries the 8-byte set-up packet, then the data to write.
Reply: status (u32; 0, or the errno that libusb would give), length (u32), `length` bytes; an OUT reply carries nothing.
"""

from __future__ import annotations

import socket
import struct
from enum import IntEnum

REQUEST = struct.Struct(">BBHII")
REPLY = struct.Struct(">II")
SETUP = struct.Struct("<BBHHH")
LONGEST = 1 << 24


class Op(IntEnum):
    """Kinds of transfer; CLAIM and RELEASE replace calls of the operating system, `endpoint` is the interface."""

    CONTROL = 1
    OUT = 2
    IN = 3
    CLAIM = 4
    RELEASE = 5
    RESET = 6


def receive(link: socket.socket, count: int) -> bytes:
    """Exactly `count` bytes.  Raises ConnectionError if the peer has closed or `count` is absurd."""
    if count > LONGEST:
        raise ConnectionError(f"a frame of {count} bytes is none")
    parts = []
    left = count
    while left:
        part = link.recv(left)
        if not part:
            raise ConnectionError("the other side has closed the connection")
        parts.append(part)
        left -= len(part)
    return b"".join(parts)
