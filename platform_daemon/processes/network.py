"""The sockets that the daemon listens on; its parent holds them as long as it lives."""

from __future__ import annotations

import socket

from drivers.errors import InputError


def listen_for_stop(host: str, requested: int | None, main: int) -> socket.socket:
    """A listening socket on the port `requested`, if given, else on the port after the main one, else on any free one.

    Raises InputError.
    """
    if requested is not None:
        return listen(host, requested, "--stop-port")
    try:
        return listen(host, main + 1 if main < 65535 else 0)
    except InputError:
        return listen(host, 0)


def listen(host: str, port: int, option: str = "--port") -> socket.socket:
    """A listening socket; port 0: any that is free.  Raises InputError."""
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        # With the protocol named asyncio sends answers without delay (TCP_NODELAY); else many wait for 40 ms.
        listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(128)
    except (OSError, UnicodeError) as error:  # UnicodeError: a name that DNS cannot hold
        why = getattr(error, "strerror", None) or str(error)
        raise InputError(
            "cannot listen", where=f"{host}:{port}", why=why, remedy=f"choose another {option} or --host"
        ) from None
    return listener
