"""Who asks: the holder of a token, or anybody on a computer where none is demanded."""

from __future__ import annotations

import ipaddress
from collections.abc import Mapping
from dataclasses import dataclass, replace

import structlog

from drivers.errors import ConfigError
from platform_daemon.schemas import Role
from platform_daemon.store import TokenFile, has_expired

from .refusals import RoleTooLow, Unauthenticated

log = structlog.get_logger()
LOCAL = "local"


@dataclass(frozen=True)
class Caller:
    """Name and role of who asks, and from which address; refused: why the role is none, or lower than it was."""

    name: str
    role: Role | None
    address: str
    refused: Unauthenticated | None = None

    @property
    def client(self) -> str:
        """Whose requests are counted together: those of one token, else of one address."""
        return f"token {self.name}" if self.role is not None and self.name != LOCAL else counted(self.address)

    def must_be(self, needed: Role | None) -> None:
        """Raises Unauthenticated, RoleTooLow."""
        if needed is None:
            return
        if self.role is not None and self.role.covers(needed):
            return
        if self.refused is not None or self.role is None:
            raise self.refused or Unauthenticated("a token is needed")
        why = f"{self.name!r} is {self.role}"
        remedy = "ask somebody who has one, or an administrator of this server"
        raise RoleTooLow(f"the role {needed} is needed", where="Authorization", why=why, remedy=remedy)


class Gate:
    """Tells callers apart.

    tokens: of the data folder; demanded: also while their file does not exist, as on an address that others reach.
    A file that was there once makes them demanded until the server ends: deleting it opens nothing.
    """

    def __init__(self, tokens: TokenFile | None = None, *, demanded: bool = False) -> None:
        if demanded and tokens is None:
            raise ValueError("tokens are demanded, and there is no file of them")
        self._tokens = tokens
        self._demanded = demanded or (tokens is not None and tokens.exists)

    def caller(self, headers: Mapping[str, str], address: str) -> Caller:
        """Who has sent these headers.

        While the tokens cannot be read, those who held one before may look and stop, and nobody may do anything else.
        """
        if self._tokens is not None and not self._demanded:
            self._demanded = self._tokens.exists
        if self._tokens is None or not self._demanded:
            return Caller(LOCAL, Role.ADMIN, address)
        kind, _, token = headers.get("authorization", "").partition(" ")
        if not token.strip() or kind.lower() != "bearer":
            remedy = "send the header `Authorization: Bearer TOKEN`; `platform-daemon token add` makes tokens"
            return _nobody(address, "the request holds no token", remedy)
        try:
            record = self._tokens.holder(token.strip())
        except ConfigError as error:
            log.error("tokens_unreadable", error=str(error))
            nobody = _nobody(
                address, "this server cannot read its tokens", "look into its log; meanwhile it can be stopped"
            )
            known = self._tokens.last_holder(token.strip())
            if known is None or has_expired(known):
                return nobody
            return replace(nobody, name=known.name, role=Role.VIEWER)
        remedy = "ask an administrator for another one (`platform-daemon token add`)"
        if record is None:
            return _nobody(address, "the token is not valid: it is wrong, or was revoked", remedy)
        if has_expired(record):
            return _nobody(address, f"the token {record.name!r} has expired on {record.expires}", remedy)
        return Caller(record.name, record.role, address)


def _nobody(address: str, what: str, remedy: str) -> Caller:
    return Caller("", None, address, Unauthenticated(what, where="Authorization", remedy=remedy))


def counted(address: str) -> str:
    """Whose it counts as: an address; of IPv6 its network, as one computer has as many addresses there as it likes."""
    try:
        found = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(found, ipaddress.IPv4Address):
        return address
    # `::ffff:10.0.0.7` is a client of IPv4 where the server listens on `::`.
    return str(found.ipv4_mapped or ipaddress.ip_network((found.packed, 64), strict=False))
