"""Answers others on a local socket, each connection in a thread of its own, so that none waits for another."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Callable
from pathlib import Path

import structlog

from drivers.errors import PlatformError
from platform_daemon.schemas import LinkAnswer, LinkCall

from .address import NAME, listening
from .errors import error_on_wire
from .hardware import Hardware
from .line import ALIVE, Line
from .wire import methods

log = structlog.get_logger()


class LinkServer:
    """Listens in `folder` until it is closed.  Raises OSError if it cannot.

    hardware: tells who answers now; what it raises is the answer; stopped: told first that everything is to stop,
    whether or not somebody answers.
    """

    def __init__(
        self, hardware: Callable[[], Hardware], folder: Path, stopped: Callable[[], None] = lambda: None
    ) -> None:
        self._hardware, self._stopped = hardware, stopped
        self.path = folder / NAME
        self._listener = listening(self.path)
        self._connections: set[socket.socket] = set()
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._accept, name="link", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Nobody is answered any more.  Idempotent."""
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        with self._lock:
            for each in self._connections:
                with contextlib.suppress(OSError):
                    each.shutdown(socket.SHUT_RDWR)
        self.path.unlink(missing_ok=True)

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection,), name="link-connection", daemon=True).start()

    def _serve(self, connection: socket.socket) -> None:
        with self._lock:
            self._connections.add(connection)
        line = Line(connection)
        try:
            while (call := line.call()) is not None:
                line.send(self._answer(call))
        except (OSError, ValueError, PlatformError) as error:  # the other end died, or is none of ours
            log.warning("link_connection_lost", error=str(error))
        finally:
            with self._lock:
                self._connections.discard(connection)
            line.close()

    def _answer(self, call: LinkCall) -> LinkAnswer:
        if call.method == ALIVE:
            return LinkAnswer(value=None, error=None)
        try:
            if call.method == "outputs_off":
                self._stopped()
            method = methods()[call.method]
            value = getattr(self._hardware(), call.method)(*method.read_arguments(call.arguments))
            return LinkAnswer(value=method.written(value), error=None)
        except Exception as error:  # whatever it is, the one who asked hears of it
            return LinkAnswer(value=None, error=error_on_wire(error))
