"""Authentication: a caller is the holder of a token, or local where no token is demanded."""

from __future__ import annotations

import ipaddress
from collections.abc import Mapping
from dataclasses import dataclass, replace

import structlog

from drivers.errors import ConfigError
from platform_daemon.core.schemas.roles import Role
from platform_daemon.core.state.tokens import TokenFile, has_expired

from .refusals import RoleTooLow, Unauthenticated

log = structlog.get_logger()
LOCAL = "local"


@dataclass(frozen=True)
class Caller:
    """The sender of a request: name, role, address.  refused: why the role is None, or lower than that of the token."""

    name: str
    role: Role | None
    address: str
    refused: Unauthenticated | None = None

    @property
    def client(self) -> str:
        """The key under which requests are counted: one token, else one address."""
        return f"token {self.name}" if self.role is not None and self.name != LOCAL else client_of(self.address)

    def must_be(self, needed: Role | None) -> None:
        """Raises Unauthenticated, RoleTooLow."""
        if needed is None:
            return
        if self.role is not None and self.role.covers(needed):
            return
        if self.refused is not None or self.role is None:
            raise self.refused or Unauthenticated("a token is needed")
        why = f"{self.name!r} is {self.role}"
        remedy = "ask an administrator of this server for one"
        raise RoleTooLow(f"the role {needed} is needed", where="Authorization", why=why, remedy=remedy)


class Authenticator:
    """Authenticates callers.

    tokens: of the data folder; demanded: even while their file does not exist, as on an address that other computers
    reach.  Once the file exists, tokens are demanded until the server ends: deleting it opens nothing.
    """

    def __init__(self, tokens: TokenFile | None = None, *, demanded: bool = False) -> None:
        if demanded and tokens is None:
            raise ValueError("tokens are demanded, and there is no file of them")
        self._tokens = tokens
        self._demanded = demanded or (tokens is not None and tokens.exists)

    def caller(self, headers: Mapping[str, str], address: str) -> Caller:
        """The sender of a request with these headers, from an address.

        While the tokens cannot be read, holders of earlier tokens may look and stop, and no other request is allowed.
        """
        if self._tokens is not None and not self._demanded:
            self._demanded = self._tokens.exists
        if self._tokens is None or not self._demanded:
            return Caller(LOCAL, Role.ADMIN, address)
        kind, _, token = headers.get("authorization", "").partition(" ")
        if not token.strip() or kind.lower() != "bearer":
            remedy = "send the header `Authorization: Bearer TOKEN`; `platform-daemon token add` makes tokens"
            return _unauthenticated(address, "the request holds no token", remedy)
        try:
            record = self._tokens.holder(token.strip())
        except ConfigError as error:
            log.error("tokens_unreadable", error=str(error))
            refused = _unauthenticated(
                address, "this server cannot read its tokens", "look into its log; meanwhile it can be stopped"
            )
            known = self._tokens.last_holder(token.strip())
            if known is None or has_expired(known):
                return refused
            return replace(refused, name=known.name, role=Role.VIEWER)
        remedy = "ask an administrator for another one (`platform-daemon token add`)"
        if record is None:
            return _unauthenticated(address, "the token is not valid: it is wrong, or was revoked", remedy)
        if has_expired(record):
            return _unauthenticated(address, f"the token {record.name!r} has expired on {record.expires}", remedy)
        return Caller(record.name, record.role, address)


def _unauthenticated(address: str, what: str, remedy: str) -> Caller:
    return Caller("", None, address, Unauthenticated(what, where="Authorization", remedy=remedy))


def client_of(address: str) -> str:
    """The client of an address; of IPv6 the /64 network, as one computer may have any number of addresses in it."""
    try:
        found = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(found, ipaddress.IPv4Address):
        return address
    # `::ffff:10.0.0.7` is a client of IPv4 where the server listens on `::`.
    return str(found.ipv4_mapped or ipaddress.ip_network((found.packed, 64), strict=False))
