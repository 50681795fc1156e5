"""POST /stop on a port and in a thread of its own: whatever the main server is busy with, this one is not."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from fastapi import FastAPI

from .certificates import Certificate
from .connections import BoundedServer, bounded_config
from .limits import Limits


@contextmanager
def stop_server(
    app: FastAPI, listener: socket.socket, limits: Limits, certificate: Certificate | None
) -> Iterator[None]:
    """The application is served on the listener as long as this holds."""
    server = BoundedServer(bounded_config(app, limits, certificate))
    # uvicorn takes signals in the main thread only.
    thread = threading.Thread(target=server.run, args=([listener],), name="stop-server", daemon=True)
    thread.start()
    try:
        yield
    finally:
        server.should_exit = True
        thread.join(timeout=5)
