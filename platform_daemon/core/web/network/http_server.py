"""An application on a listening socket: uvicorn with its own settings, in a thread of its own.

The server is meant for loopback and for a network of known computers.  It bounds what one request may hold, and how
many connections there are, but does not tell a crowd of strangers from its users: "Behind a reverse proxy" in
`docs/howto/rest-and-network.md` says what to put in front of it.  A flood of the web process delays no shot, because
the process that owns the hardware is another one, and POST /stop has a port and a process of its own.
"""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import uvicorn
from starlette.types import ASGIApp

from .certificates import Certificate
from .limits import Limits

_MAX_HEAD_BYTES = 32 * 1024
_BACKLOG = 1024
"""Connections that the kernel keeps until they are accepted."""
_GRACEFUL_SHUTDOWN_S = 3
_JOIN_S = 5.0
_START_POLL_S, _JOIN_POLL_S = 0.01, 0.2


class HttpServer:
    """A server that answers; see `running_server`."""

    def __init__(self, server: uvicorn.Server, thread: threading.Thread) -> None:
        self._server = server
        self._thread = thread

    def wait(self) -> None:
        """Wait until the server ends, or until an interrupt."""
        while self._thread.is_alive():
            self._thread.join(_JOIN_POLL_S)  # a signal that reaches another thread does not wake this one

    def wait_until_started(self) -> None:
        """Wait until the server takes requests, or has ended."""
        while self._thread.is_alive() and not self._server.started:
            time.sleep(_START_POLL_S)


@contextmanager
def running_server(
    app: ASGIApp,
    listener: socket.socket,
    *,
    limits: Limits,
    certificate: Certificate | None = None,
    max_connections: int | None = None,
) -> Iterator[HttpServer]:
    """Serve an application on a listening socket for as long as the context is open.

    certificate: None for plain HTTP; max_connections: connections beyond that are answered 503, None: as many as the
    process has file descriptors for.
    """
    # The kernel ends a connection whose client has acknowledged nothing for so long, as one that does not read: what
    # waits for it in memory is given back.  Accepted sockets inherit the option.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, round(1e3 * limits.stalled_s))
    server = uvicorn.Server(_configuration(app, limits, certificate, max_connections))
    # uvicorn takes signals in the main thread only.
    thread = threading.Thread(target=server.run, args=([listener],), name="server", daemon=True)
    thread.start()
    try:
        running = HttpServer(server, thread)
        running.wait_until_started()
        yield running
    finally:
        server.should_exit = True
        thread.join(timeout=_JOIN_S)


def _configuration(
    app: ASGIApp, limits: Limits, certificate: Certificate | None, max_connections: int | None
) -> uvicorn.Config:
    return uvicorn.Config(
        app,
        http="h11",
        loop="asyncio",
        ws="none",
        log_config=None,
        # At the level of warnings uvicorn logs every request that is not HTTP: a client could fill the disk with them.
        log_level="error",
        access_log=False,
        backlog=_BACKLOG,
        limit_concurrency=max_connections,
        timeout_keep_alive=limits.keep_alive_s,
        timeout_graceful_shutdown=_GRACEFUL_SHUTDOWN_S,
        h11_max_incomplete_event_size=_MAX_HEAD_BYTES,
        # A header must not tell where a client is: the audit log would believe it.
        proxy_headers=False,
        ssl_certfile=None if certificate is None else certificate.chain,
        ssl_keyfile=None if certificate is None else certificate.key,
    )
