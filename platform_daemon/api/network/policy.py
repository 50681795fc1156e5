"""What a server demands of those who ask; handed in once, when the application is made."""

from __future__ import annotations

from dataclasses import dataclass, field

from platform_daemon.store import AuditLog

from .callers import Gate
from .limits import Limits
from .origins import LOOPBACK


@dataclass(frozen=True)
class Network:
    """Rules of a server.  The default is that of one on loopback without tokens.

    Attributes:
        gate: tells callers apart.
        names: hosts that it is called by.
        limits: how much anybody may ask for.
        audit: where changes are written down; None: nowhere, as in tests of single routes.
    """

    gate: Gate = field(default_factory=Gate)
    names: frozenset[str] = frozenset(LOOPBACK)
    limits: Limits = field(default_factory=Limits)
    audit: AuditLog | None = None
