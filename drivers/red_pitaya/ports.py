"""Connecting to one port of RedPitayaDAQServer, and what is in the way.

Whoever connects to the data port only (a port scan does) stays in its queue, is taken for the data connection of the
next client, and from then on everybody gets the one of the client before; two of them fill the queue.  Nobody is told,
but no sample ever arrives.  Command connections without data ones use such strangers up.
"""

from __future__ import annotations

import select
import socket

from drivers.errors import DeviceNotFound

CONNECT_S = 3.0  # TCP connect
QUEUE = 4  # more connections than wait at a port
ANSWER_S = 0.5  # a server that has both its connections answers within this time


class Unanswered(DeviceNotFound):
    """Neither accepted nor refused: nobody there, or the queue of the port is full."""


def use_up_strangers(host: str, command_port: int) -> None:
    """Let the server take the data connections that strangers left behind; once it waits for one, which keeps it from
    answering, none is left.  Raises DeviceNotFound."""
    for _ in range(QUEUE):
        with connect(host, command_port) as command:
            command.sendall(b"\n*IDN?\n")
            readable, _, _ = select.select([command], [], [], ANSWER_S)
        if not readable:
            return


def connect(host: str, port: int, other: socket.socket | None = None) -> socket.socket:
    """A TCP connection; closes `other` if there is none to be had.  Raises DeviceNotFound."""
    try:
        return socket.create_connection((host, port), CONNECT_S)
    except OSError as error:
        if other is not None:
            other.close()
        kind = Unanswered if isinstance(error, TimeoutError) else DeviceNotFound
        raise kind(
            "no I/O card answers",
            where=f"{host}:{port}",
            why=error.strerror or str(error),
            remedy="check address, power and network of the card, and that its DAQ server runs",
        ) from None


def closed_within(peer: socket.socket, seconds: float) -> bool:
    """True if the other side closes within that time."""
    readable, _, _ = select.select([peer], [], [], seconds)
    if not readable:
        return False
    try:
        return peer.recv(1, socket.MSG_PEEK) == b""
    except OSError:
        return True
