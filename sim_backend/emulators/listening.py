"""A TCP port with one thread per connection."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable
from contextlib import suppress

from drivers.errors import ConfigError


def listening_socket(host: str, port: int, backlog: int = 16) -> socket.socket:
    """A listening socket, port 0: any free one.  Raises ConfigError if it cannot be had."""
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(backlog)
    except OSError as error:
        listener.close()
        raise ConfigError(
            "cannot listen",
            where=f"{host}:{port}",
            why=error.strerror or str(error),
            remedy="choose another address or port, 0 for any free one",
        ) from None
    return listener


def hang_up(link: socket.socket) -> None:
    """Close a connection for both directions, also while another thread reads from it."""
    with suppress(OSError):
        link.shutdown(socket.SHUT_RDWR)
    link.close()


class Listener:
    """Calls `serve(connection)` in a thread of its own for every client, and closes the connection afterwards."""

    def __init__(self, host: str, port: int, serve: Callable[[socket.socket], None], name: str) -> None:
        self._socket = listening_socket(host, port)
        self.port: int = self._socket.getsockname()[1]
        self._serve = serve
        self._name = name
        self._links: set[socket.socket] = set()
        threading.Thread(target=self._accept, name=f"{name}-accept", daemon=True).start()

    def close(self) -> None:
        """Stop listening and cut all connections."""
        hang_up(self._socket)
        self.cut()

    def cut(self) -> None:
        """Cut all connections."""
        for link in tuple(self._links):
            hang_up(link)

    def _accept(self) -> None:
        with suppress(OSError):  # the socket was closed
            while True:
                link, _ = self._socket.accept()
                self._links.add(link)
                threading.Thread(target=self._run, args=(link,), name=self._name, daemon=True).start()

    def _run(self, link: socket.socket) -> None:
        try:
            self._serve(link)
        finally:
            self._links.discard(link)
            hang_up(link)
