"""By which names the server is called, and from which pages of a browser.

A page from anywhere can have its own name lead to this computer (DNS rebinding) and then ask what it likes, as far as
the browser is concerned: the request still names that host, which nobody here is called by.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping

from .refusals import ForeignHost, ForeignOrigin

LOOPBACK = ("127.0.0.1", "localhost", "::1")
HARMLESS = ("GET", "HEAD", "OPTIONS")
"""Methods that change nothing."""
NOT_OURS = ("cross-site", "same-site")
"""What a browser says of a page that another server has sent."""
NETLOC = re.compile(r"(?:\[([0-9a-f:.]+)\]|([^][:/?#@,\s]+))(?::\d*)?", re.IGNORECASE)
"""A name or an address, with or without a port, and nothing else: what would be a user or a path names no host."""


def host_of(netloc: str) -> str:
    """`[::1]:8212` -> `::1`; empty for what is no name with a port."""
    found = NETLOC.fullmatch(netloc)
    return "" if found is None else (found[1] or found[2]).lower().removesuffix(".")


def check_host(headers: Mapping[str, str], names: Collection[str]) -> None:
    """Raises ForeignHost unless the request names this server."""
    said = headers.get("host", "")
    if host_of(said) not in names:
        why = f"this server is called {', '.join(sorted(names))}"
        remedy = "use one of these names, or start the server with --allowed-host NAME"
        raise ForeignHost(f"{said!r} is not this server", where="Host", why=why, remedy=remedy)


def check_origin(method: str, headers: Mapping[str, str]) -> None:
    """Raises ForeignOrigin if a page of another server wants to change something.

    Programs that are no browser say neither, and are let through.
    """
    if method in HARMLESS:
        return
    origin, site = headers.get("origin"), headers.get("sec-fetch-site", "")
    if (origin is not None and origin.partition("//")[2] != headers.get("host")) or site in NOT_OURS:
        why = "a page in a browser must not move hardware behind its reader's back"
        remedy = "use a page of this server, as /docs, or a program that is no browser"
        raise ForeignOrigin(
            f"the request comes from a page of {origin or site}", where="Origin", why=why, remedy=remedy
        )
