"""The network rules of the web process and of the stop process, which are the same."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from platform_daemon.core.state.audit import audit_log_in
from platform_daemon.core.state.tokens import tokens_in
from platform_daemon.core.web.network.listening import certificate_of, rules

from .options import ServeOptions

if TYPE_CHECKING:
    from platform_daemon.core.web.network.certificates import Certificate
    from platform_daemon.core.web.network.policy import Network


def rules_for(options: ServeOptions) -> tuple[Network, Certificate | None]:
    """The rules, and the certificate of TLS.  Raises InputError, ConfigError."""
    certificate = certificate_of(options.tls_cert, options.tls_key)
    tokens = tokens_in(options.data)
    if options.initial_tokens is not None:
        tokens.remember(options.initial_tokens)
    network = rules(
        options.host,
        options.allowed_hosts,
        certificate,
        insecure=options.insecure_network,
        tokens=tokens,
        audit=audit_log_in(options.data),
        respawned=options.respawned,
    )
    return replace(network, port=options.port, stop_port=options.stop_port), certificate
