"""Names of the server, and origins of the pages from which a browser sends requests.

Any page can make its own name resolve to this computer (DNS rebinding) and then, for the browser, has the same origin:
its requests still name that host, which is not a name of this server.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping

from .refusals import ForeignHost, ForeignOrigin

LOOPBACK = ("127.0.0.1", "localhost", "::1")
SAFE_METHODS = ("GET", "HEAD", "OPTIONS")
"""Methods that change nothing (RFC 9110, 9.2.1)."""
FOREIGN_SITES = ("cross-site", "same-site")
"""`Sec-Fetch-Site` of a page that another server has sent."""
NETLOC = re.compile(r"(?:\[([0-9a-f:.]+)\]|([^][:/?#@,\s]+))(?::\d*)?", re.IGNORECASE)
"""A name or an address, with or without a port, and nothing else: what would be a user or a path names no host."""


def host_of(netloc: str) -> str:
    """`[::1]:8212` -> `::1`; empty for what is no name with a port."""
    found = NETLOC.fullmatch(netloc)
    return "" if found is None else (found[1] or found[2]).lower().removesuffix(".")


def check_host(headers: Mapping[str, str], names: Collection[str]) -> None:
    """Raises ForeignHost unless the request names this server."""
    host = headers.get("host", "")
    if host_of(host) not in names:
        why = f"this server is called {', '.join(sorted(names))}"
        remedy = "use one of these names, or start the server with --allowed-host NAME"
        raise ForeignHost(f"{host!r} is not this server", where="Host", why=why, remedy=remedy)


def page_origins(names: Collection[str], port: int) -> frozenset[str]:
    """Origins of the pages of a server on this port, by each of its names; none for port 0.

    A page of TLS and one without cannot have the same port, so that both may be accepted.
    """
    if port == 0:
        return frozenset()
    hosts = [f"[{name}]" if ":" in name else name for name in names]
    usual = {"http": 80, "https": 443}  # a browser leaves the usual port of a scheme out
    return frozenset(f"{s}://{h}" + ("" if port == usual[s] else f":{port}") for s in usual for h in hosts)


def check_origin(method: str, headers: Mapping[str, str], accepted: Collection[str] = ()) -> None:
    """Raises ForeignOrigin if a page of another server wants to change something; accepted: origins that may.

    Programs other than browsers send neither header, and are accepted.
    """
    origin, site = headers.get("origin"), headers.get("sec-fetch-site", "")
    if method in SAFE_METHODS or origin in accepted:
        return
    if (origin is not None and origin.partition("//")[2] != headers.get("host")) or site in FOREIGN_SITES:
        why = "a page in a browser must not move hardware behind its reader's back"
        remedy = "use a page of this server, as /docs, or a program that is no browser"
        raise ForeignOrigin(
            f"the request comes from a page of {origin or site}", where="Origin", why=why, remedy=remedy
        )
