"""The rules of a server, which are passed when the application is made."""

from __future__ import annotations

from dataclasses import dataclass, field

from platform_daemon.core.state.audit import AuditLog

from .callers import Authenticator
from .limits import Limits
from .origins import LOOPBACK


@dataclass(frozen=True, kw_only=True)
class Network:
    """Rules of a server.  The default is that of one on loopback without tokens.

    Attributes:
        authenticator: authenticates callers.
        names: hosts by which clients call the server.
        limits: how much clients may ask for.
        audit: where changes are recorded; None: nowhere, as in tests of single routes.
        port, stop_port: that the web process and the stop process listen on; 0: not known.
        page_origins: origins of pages that may send what changes something, besides those of this server itself.
    """

    authenticator: Authenticator = field(default_factory=Authenticator)
    names: frozenset[str] = frozenset(LOOPBACK)
    limits: Limits = field(default_factory=Limits)
    audit: AuditLog | None = None
    port: int = 0
    stop_port: int = 0
    page_origins: frozenset[str] = frozenset()
