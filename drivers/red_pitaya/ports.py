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
    """Neither accepted nor refused: nobody there, or the queue of the port is full."""


def connect(host: str, port: int, timeout_s: float = CONNECT_S) -> socket.socket:
    """A TCP connection.  Raises DeviceNotFound.

    A name is asked for once, and again after its address has failed or `ask_anew`: to ask takes seconds where nobody
    answers, for each port of each card, and that would be how long a stop takes, or why it fails.
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


def ask_anew(host: str) -> None:
    """The card may have another address now, and another card its old one."""
    _ADDRESSES.pop(host, None)


def acknowledge_at_once(link: socket.socket) -> None:
    """Until the next receive: the server writes in small pieces and holds each back until the one before is
    acknowledged, which a receiver delays by 40 ms.  The kernel forgets this, so it is asked for around every receive.
    """
    if ACKNOWLEDGE_AT_ONCE is not None:
        link.setsockopt(socket.IPPROTO_TCP, ACKNOWLEDGE_AT_ONCE, 1)


def notice_its_end(link: socket.socket, *, from_now_on: bool) -> None:
    """Ask the other computer each second whether it is there, where nothing else is sent: one that was switched off
    does not say so, and knows of no connection once it is on again.  Or do so no more."""
    link.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, from_now_on)
    for name, value in (("TCP_KEEPIDLE", 1), ("TCP_KEEPINTVL", 1), ("TCP_USER_TIMEOUT", from_now_on * GONE_S * 1000)):
        if hasattr(socket, name):
            link.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


def said_within(peer: socket.socket, seconds: float) -> bytes | None:
    """What the other side says unasked within that time, left unread; b"" if it closes, None if it keeps silent."""
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
