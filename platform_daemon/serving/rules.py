"""By which rules the processes that listen serve; web and stop serve by the same ones."""

from __future__ import annotations

from typing import TYPE_CHECKING

from platform_daemon.api import certificate_of, rules
from platform_daemon.store import audit_log_in, tokens_in

from .options import ServeOptions

if TYPE_CHECKING:
    from platform_daemon.api import Certificate, Network


def rules_for(options: ServeOptions) -> tuple[Network, Certificate | None]:
    """The rules, and what TLS is made with.  Raises InputError, ConfigError."""
    certificate = certificate_of(options.tls_cert, options.tls_key)
    tokens = tokens_in(options.data)
    if options.tokens_before is not None:
        tokens.remember(options.tokens_before)
    network = rules(
        options.host,
        options.allowed_hosts,
        certificate,
        insecure=options.insecure_network,
        tokens=tokens,
        audit=audit_log_in(options.data),
        again=options.again,
    )
    return network, certificate
