"""Answers others on a local socket, each connection in a thread of its own, so that none waits for another."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import structlog

from drivers.errors import PlatformError
from platform_daemon.core.schemas.rpc import RpcAnswer, RpcCall

from .address import NAME, listening
from .errors import error_on_wire, processes_differ
from .framing import ALIVE, JsonLineConnection
from .stopping import StoppedMeanwhile
from .wire import methods

log = structlog.get_logger()
_LOOK_S = 1.0
_AGAIN_S = 0.1


class LinkServer:
    """Listens in `folder` until it is closed.  Raises OSError if it cannot.

    services: the service of a name, "" is the platform service; what it raises is the answer; stopped: is called first
    when everything is to stop, whether or not a service answers.
    """

    def __init__(
        self, services: Callable[[str], Any], folder: Path, stopped: Callable[[], None] = lambda: None
    ) -> None:
        self._services, self._stopped = services, stopped
        self.path = folder / NAME
        self._listener, self._closed = listening(self.path), threading.Event()
        self._at = _identity(self.path)
        self._connections: set[socket.socket] = set()
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._accept, name="link", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Answer no more calls, and close all connections.  Idempotent."""
        self._closed.set()
        with self._lock:
            with contextlib.suppress(OSError):
                self._listener.shutdown(socket.SHUT_RDWR)
            self._listener.close()
            for each in self._connections:
                with contextlib.suppress(OSError):
                    each.shutdown(socket.SHUT_RDWR)
            if _identity(self.path) == self._at:  # not another daemon's, whose folder has come to be here
                self.path.unlink(missing_ok=True)

    def _accept(self) -> None:
        """Accept connections; one that fails, for want of descriptors or threads, does not end this."""
        while not self._closed.is_set():
            try:
                if not select.select([self._listener], [], [], _LOOK_S)[0]:
                    self._be_there()
                    continue
                connection, _ = self._listener.accept()
                threading.Thread(target=self._serve, args=(connection,), name="link-connection", daemon=True).start()
            except (OSError, ValueError, RuntimeError) as error:  # ValueError: it was closed
                if not self._closed.is_set():
                    log.error("link_refused", error=str(error))
                    time.sleep(_AGAIN_S)

    def _be_there(self) -> None:
        """Create the socket again if its file was deleted, so that a stop can reach this process.  Raises OSError."""
        with self._lock:
            if self._closed.is_set() or _identity(self.path) is not None or not self.path.parent.is_dir():
                return
            gone, self._listener = self._listener, listening(self.path, replace=False)
            self._at = _identity(self.path)
            gone.close()
        log.warning("socket_made_anew", path=str(self.path))

    def _serve(self, connection: socket.socket) -> None:
        with self._lock:
            self._connections.add(connection)
        line = JsonLineConnection(connection)
        try:
            while (call := line.call()) is not None:
                line.send(self._answer(call))
        except (OSError, ValueError, PlatformError) as error:  # the other end died, or is another program
            log.warning("link_connection_lost", error=str(error))
        finally:
            with self._lock:
                self._connections.discard(connection)
            line.close()

    def _answer(self, call: RpcCall) -> RpcAnswer:
        if call.method == ALIVE:
            return RpcAnswer(value=None, error=None)
        try:
            if call.method == "outputs_off":
                self._stopped()
            try:
                method = methods()[call.method]
                arguments = method.read_arguments(call.arguments)
            except (ValueError, LookupError) as error:
                raise processes_differ(call.method, error) from error
            service, _, name = call.method.rpartition(".")
            value = getattr(self._owner(service, name), name)(*arguments)
            return RpcAnswer(value=method.write_answer(value), error=None)
        except Exception as error:  # any error is an answer to the caller
            return RpcAnswer(value=None, error=error_on_wire(error))

    def _owner(self, service: str, method: str) -> Any:
        try:
            return self._services(service)
        except StoppedMeanwhile:
            if method != "outputs_off":
                raise
            return self._services(service)  # interrupted by another stop, which wants the same


def _identity(path: Path) -> tuple[int, int] | None:
    """Device and inode of the file; None: there is none, or it cannot be read."""
    try:
        found = os.lstat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino
