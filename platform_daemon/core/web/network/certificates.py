"""Checks before the server listens that a certificate is valid for the names of the server."""

from __future__ import annotations

import ssl
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from drivers.errors import ConfigError


@dataclass(frozen=True)
class Certificate:
    """Files in PEM.  chain: the certificate and those that lead to its authority; key: its private key."""

    chain: Path
    key: Path


def check_certificate(certificate: Certificate, names: Sequence[str]) -> None:
    """A handshake in memory, with a client that trusts this certificate and calls the server by each name.

    Raises ConfigError if the files cannot be used, do not belong together, or if the certificate is not good for one of
    the names or not now.
    """
    server = _server(certificate)
    for name in names:
        try:
            _shake_hands(server, _client(certificate), name)
        except ssl.SSLCertVerificationError as error:
            remedy = "give the certificate of this server, or with --allowed-host the names that it holds"
            what, why = f"no client would take this certificate for {name}", error.verify_message
            raise ConfigError(what, where=str(certificate.chain), why=why, remedy=remedy) from None
        except ssl.SSLError as error:
            remedy = "give another certificate"
            what, why = "no connection can be made with this certificate", error.reason or str(error)
            raise ConfigError(what, where=str(certificate.chain), why=why, remedy=remedy) from None


def _server(certificate: Certificate) -> ssl.SSLContext:
    for path, option in ((certificate.chain, "--tls-cert"), (certificate.key, "--tls-key")):
        try:
            path.read_bytes()
        except OSError as error:
            what, why = f"{option} cannot be read", error.strerror or str(error)
            raise ConfigError(what, where=str(path), why=why, remedy="check the path and its rights") from None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        # An empty password: a prompt on the terminal would keep an unattended server from starting.
        context.load_cert_chain(certificate.chain, certificate.key, password="")
    except ssl.SSLError as error:
        if error.reason == "KEY_VALUES_MISMATCH":
            what, remedy = "the key does not belong to the certificate", "give the key that it was made with"
        else:
            what, remedy = "no certificate and key in PEM, or the key has a password", "give them in PEM, without one"
        where, why = f"{certificate.chain}, {certificate.key}", error.reason or str(error)
        raise ConfigError(what, where=where, why=why, remedy=remedy) from None
    return context


def _client(certificate: Certificate) -> ssl.SSLContext:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.load_verify_locations(certificate.chain)
    # The certificate itself is trusted, whatever its authority: only its names and its dates are checked here.
    context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
    return context


def _shake_hands(server: ssl.SSLContext, client: ssl.SSLContext, name: str) -> None:
    """Raises SSLError."""
    to_server, to_client = ssl.MemoryBIO(), ssl.MemoryBIO()
    ends = (
        client.wrap_bio(to_client, to_server, server_hostname=name),
        server.wrap_bio(to_server, to_client, server_side=True),
    )
    open_ends = set(ends)
    for _ in range(10):
        for end in ends:
            if end in open_ends:
                try:
                    end.do_handshake()
                    open_ends.discard(end)
                except ssl.SSLWantReadError:
                    continue
        if not open_ends:
            return
    raise ssl.SSLError("the handshake does not end")
