"""Those whom a listener has accepted and who are not through with TLS: no protocol sees them yet, nor counts them.

A thousand that connect and say nothing would otherwise take all file descriptors of the process, and with them those
that a recording needs.
"""

from __future__ import annotations

import contextlib
import os
import socket
from typing import Any

from .limits import Limits


class Entrance(socket.socket):
    """A listener that hangs up on the one that has stood outside for longest where there are too many."""

    def __init__(self, listener: socket.socket, limits: Limits) -> None:
        """Accepts in the place of a listener, which its owner closes all the same."""
        super().__init__(listener.family, listener.type, listener.proto, fileno=os.dup(listener.fileno()))
        self._most = limits.handshakes
        self._outside: dict[int, socket.socket] = {}  # by file descriptor, those who came first are first

    def accept(self) -> tuple[socket.socket, Any]:
        """Another one, who is outside until `let_in`."""
        link, address = super().accept()
        self._outside.pop(link.fileno(), None)  # of one that was closed meanwhile
        self._outside[link.fileno()] = link
        if len(self._outside) > self._most:
            self._outside = {number: each for number, each in self._outside.items() if each.fileno() == number}
        while len(self._outside) > self._most:
            longest = self._outside.pop(next(iter(self._outside)))
            with contextlib.suppress(OSError):  # it has left itself
                longest.shutdown(socket.SHUT_RDWR)  # asyncio, which reads from it, then closes it
        return link, address

    def let_in(self, link: socket.socket) -> None:
        """It is through with TLS: its protocol counts it from here on."""
        self._outside.pop(link.fileno(), None)
