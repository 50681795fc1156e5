"""On which address the server may listen: loopback without conditions, others with tokens and TLS or an explicit
`--insecure-network`."""

from __future__ import annotations

import ipaddress
from collections.abc import Sequence
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.state.audit import AuditLog
from platform_daemon.core.state.tokens import TokenFile, has_expired

from .callers import Authenticator
from .certificates import Certificate, check_certificate
from .origins import LOOPBACK, host_of
from .policy import Network


def is_loopback(host: str) -> bool:
    """Can only this computer reach the address?"""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def certificate_of(chain: Path | None, key: Path | None) -> Certificate | None:
    """Raises InputError if one is there without the other."""
    if chain is None and key is None:
        return None
    if chain is None or key is None:
        missing = "--tls-cert" if chain is None else "--tls-key"
        raise InputError(
            "TLS needs a certificate and its key", where=missing, remedy="give both --tls-cert and --tls-key"
        )
    return Certificate(chain, key)


def rules(
    host: str,
    names: Sequence[str],
    certificate: Certificate | None,
    *,
    insecure: bool,
    tokens: TokenFile,
    audit: AuditLog,
    respawned: bool = False,
) -> Network:
    """The rules for a server on this address; names: further ones that clients call it by; respawned: the process
    is started again, so that certificate and tokens, which may have expired meanwhile, are not checked.

    Raises InputError with the option that is missing, ConfigError for tokens or certificates that are not usable.
    """
    own, called = _name_of(host, "--host"), tuple(_name_of(name, "--allowed-host") for name in names)
    local, wild = is_loopback(host), _is_every_address(host)
    if not local:
        _check_public_address(host, certificate, called, insecure=insecure, wild=wild)
    if not respawned:
        _check_what_may_expire(host, certificate, called, tokens, local=local)
    names = (*LOOPBACK, *called) if wild else (*LOOPBACK, *called, own)
    return Network(authenticator=Authenticator(tokens, demanded=not local), names=frozenset(names), audit=audit)


def _name_of(given: str, option: str) -> str:
    """The name in the form in which requests are compared with it.  Raises InputError for what cannot be a host."""
    name = given.lower().removesuffix(".")
    if not name or host_of(f"[{name}]" if ":" in name else name) != name:
        what, why = f"{given!r} is no name of a server", "it is compared with the host that requests name"
        remedy = "give a name or an address alone, without scheme, port or brackets"
        raise InputError(what, where=option, why=why, remedy=remedy)
    return name


def _check_public_address(
    host: str, certificate: Certificate | None, names: Sequence[str], *, insecure: bool, wild: bool
) -> None:
    if certificate is None and not insecure:
        why = f"others can reach {host}, and would see tokens and data on the wire"
        remedy = "give --tls-cert and --tls-key, or say --insecure-network where the network itself is safe"
        raise InputError("this address needs TLS", where="--host", why=why, remedy=remedy)
    if wild and not names:
        why = f"{host} stands for all addresses of this computer, and none of its names"
        remedy = "say with --allowed-host by which name or address clients call it; may be repeated"
        raise InputError("the server must know its names", where="--host", why=why, remedy=remedy)


def _check_what_may_expire(
    host: str, certificate: Certificate | None, names: Sequence[str], tokens: TokenFile, *, local: bool
) -> None:
    if certificate is not None:
        check_certificate(certificate, names or (host,))
    known = tokens.records()
    if not local and not any(not has_expired(record) for record in known):
        why = f"others can reach {host}, and there is no valid token"
        remedy = f"`platform-daemon token add NAME --role admin --data {tokens.path.parent}`, then start again"
        raise InputError("there are no tokens", where="--host", why=why, remedy=remedy)


def _is_every_address(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_unspecified
    except ValueError:
        return False
