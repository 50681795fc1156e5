"""Connecting to one port of RedPitayaDAQServer."""

from __future__ import annotations

import select
import socket

from drivers.errors import DeviceNotFound

CONNECT_S = 3.0  # TCP connect
_ADDRESSES: dict[str, str] = {}  # of names, as they were when a card was last reached
ACKNOWLEDGE_AT_ONCE: int | None = getattr(socket, "TCP_QUICKACK", None)  # Linux
GONE_S = 10  # a card whose network has not answered for so long is off


class Unanswered(DeviceNotFound):
    """The connection was neither accepted nor refused: no host at the address, or the port's queue is full."""


def connect(host: str, port: int, timeout_s: float = CONNECT_S) -> socket.socket:
    """A TCP connection.  Raises DeviceNotFound.

    A host name is resolved once, and again after its address has failed or after `forget_address`: where no name
    server answers, each look-up takes seconds, which would delay a stop or make it fail.
    """
    try:
        made = socket.create_connection((_ADDRESSES.get(host, host), port), timeout_s)
    except OSError as error:
        _ADDRESSES.pop(host, None)
        kind = Unanswered if isinstance(error, TimeoutError) else DeviceNotFound
        raise kind(
            "no I/O card answers",
            where=f"{host}:{port}",
            why=error.strerror or str(error),
            remedy="check address, power and network of the card, and that its DAQ server runs",
        ) from None
    made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    if made.family == socket.AF_INET:
        _ADDRESSES[host] = made.getpeername()[0]
    return made


def forget_address(host: str) -> None:
    """Resolve the host name again next time: the card may have another address, and another card its old one."""
    _ADDRESSES.pop(host, None)


def acknowledge_at_once(link: socket.socket) -> None:
    """Acknowledge without delay until the next receive (TCP_QUICKACK).

    The server writes in small pieces and holds each back until the one before is acknowledged, which a receiver delays
    by 40 ms.  The kernel resets the option, so it is set before every receive.
    """
    if ACKNOWLEDGE_AT_ONCE is not None:
        link.setsockopt(socket.IPPROTO_TCP, ACKNOWLEDGE_AT_ONCE, 1)


def set_keepalive(link: socket.socket, *, on: bool) -> None:
    """Switch TCP keep-alive probes, one each second, on or off, for a connection on which nothing is sent: a computer
    that was switched off does not close its connections, and does not know them when it is on again."""
    link.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, on)
    for name, value in (("TCP_KEEPIDLE", 1), ("TCP_KEEPINTVL", 1), ("TCP_USER_TIMEOUT", on * GONE_S * 1000)):
        if hasattr(socket, name):
            link.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


def peek(peer: socket.socket, seconds: float) -> bytes | None:
    """Bytes that the peer sends without a request within that time, left unread; b"" if it closes, None if none."""
    looks = select.poll()  # select takes no file number above 1023
    try:
        looks.register(peer, select.POLLIN)
    except ValueError:  # it was closed on this side
        return b""
    if not looks.poll(seconds * 1e3):
        return None
    try:
        return peer.recv(80, socket.MSG_PEEK)
    except OSError:
        return b""
