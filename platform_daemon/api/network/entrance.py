"""Those whom a listener has accepted and who are not through with TLS: no protocol sees them yet, nor counts them.

A thousand that connect and say nothing would otherwise take all file descriptors of the process, and with them those
that a recording needs.
"""

from __future__ import annotations

import contextlib
import os
import socket
from typing import Any

from .callers import counted
from .limits import Limits


class Entrance(socket.socket):
    """A listener that hangs up where too many stand outside: on the one that has done so for longest, of the client
    that has most of them there.  One that connects again and again takes the places of its own connections only."""

    def __init__(self, listener: socket.socket, limits: Limits) -> None:
        """Accepts in the place of a listener, which its owner closes all the same."""
        super().__init__(listener.family, listener.type, listener.proto, fileno=os.dup(listener.fileno()))
        self._most = limits.handshakes
        self._outside: dict[str, dict[int, socket.socket]] = {}  # by client and descriptor, those who came first first
        self._whose: dict[int, str] = {}  # by descriptor

    def accept(self) -> tuple[socket.socket, Any]:
        """Another one, who is outside until `let_in`."""
        link, address = super().accept()
        self._forget(link.fileno())  # one that was closed meanwhile
        client = self._whose[link.fileno()] = counted(address[0])
        self._outside.setdefault(client, {})[link.fileno()] = link
        if len(self._whose) > self._most:
            self._forget_closed()
        while len(self._whose) > self._most:
            longest = next(iter(max(self._outside.values(), key=len).values()))
            self._forget(longest.fileno())
            with contextlib.suppress(OSError):  # it has left itself
                longest.shutdown(socket.SHUT_RDWR)  # asyncio, which reads from it, then closes it
        return link, address

    def let_in(self, link: socket.socket) -> None:
        """It is through with TLS: its protocol counts it from here on."""
        self._forget(link.fileno())

    def _forget_closed(self) -> None:
        there = [each for of_one in self._outside.values() for each in of_one.items()]
        for number, link in there:
            if link.fileno() != number:
                self._forget(number)

    def _forget(self, number: int) -> None:
        client = self._whose.pop(number, None)
        if client is not None:
            del self._outside[client][number]
            if not self._outside[client]:
                del self._outside[client]
