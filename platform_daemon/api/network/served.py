"""An application on its socket, in a thread of its own."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from fastapi import FastAPI

from .certificates import Certificate
from .connections import BoundedServer, bounded_config
from .limits import Limits

_END_S = 5.0
_STEP_S, _LOOK_S = 0.01, 0.2


class Serving:
    """A server that answers."""

    def __init__(self, server: BoundedServer, thread: threading.Thread) -> None:
        self._server, self._thread = server, thread

    def wait(self) -> None:
        """Until it ends, or an interrupt."""
        while self._thread.is_alive():
            self._thread.join(_LOOK_S)  # a signal that reaches another thread does not wake this one

    def wait_until_it_answers(self) -> None:
        """Until it takes requests, or has ended."""
        while self._thread.is_alive() and not self._server.started:
            time.sleep(_STEP_S)


@contextmanager
def served(app: FastAPI, listener: socket.socket, limits: Limits, certificate: Certificate | None) -> Iterator[Serving]:
    """The application is served on the listener as long as this holds."""
    server = BoundedServer(bounded_config(app, limits, certificate))
    # uvicorn takes signals in the main thread only.
    thread = threading.Thread(target=server.run, args=([listener],), name="server", daemon=True)
    thread.start()
    try:
        serving = Serving(server, thread)
        serving.wait_until_it_answers()
        yield serving
    finally:
        server.should_exit = True
        thread.join(timeout=_END_S)
