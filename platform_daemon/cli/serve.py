"""`platform-daemon serve`: the daemon with its REST interface."""

from __future__ import annotations

import logging
import socket
from pathlib import Path
from typing import Annotated

import typer

from drivers.errors import InputError

from .interrupts import heed_one_interrupt
from .logs import log_from
from .options import EndpointsOption, PlatformOption, SetOption, library

HostOption = Annotated[
    str, typer.Option(help="Address to listen on; one that others reach needs tokens, and TLS or --insecure-network.")
]
StopPortOption = Annotated[
    int | None,
    typer.Option(
        help="Port that does nothing but stop; 0: any free one; default: the one after --port, if free.",
        min=0,
        max=65535,
    ),
]
CertificateOption = Annotated[Path | None, typer.Option(help="Certificate of this server, PEM.")]
KeyOption = Annotated[Path | None, typer.Option(help="Its key, PEM, without a password.")]
InsecureOption = Annotated[
    bool, typer.Option("--insecure-network", help="Listen without TLS where others can read along.")
]
NameOption = Annotated[
    list[str] | None, typer.Option("--allowed-host", help="A further name that clients call it by; may be repeated.")
]


def serve(
    platform: PlatformOption = "simulated",
    host: HostOption = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port to listen on; 0: any free one.", min=0, max=65535)] = 8212,
    stop_port: StopPortOption = None,
    data: Annotated[Path, typer.Option(help="Folder of recordings and fits.")] = Path("data"),
    resonators: Annotated[Path | None, typer.Option(help="Folder of further resonator files, by name.")] = None,
    overrides: SetOption = None,
    endpoints: EndpointsOption = None,
    tls_cert: CertificateOption = None,
    tls_key: KeyOption = None,
    insecure_network: InsecureOption = False,
    allowed_host: NameOption = None,
) -> None:
    """Run the daemon until SIGTERM or Ctrl-C; outputs go off first."""
    from platform_daemon.api import Server, certificate_of, create_api, create_stop_api, rules, stop_server
    from platform_daemon.app import create_context, start_engine
    from platform_daemon.engine import JobRecords, open_catalogue
    from platform_daemon.settings import load_platform
    from platform_daemon.store import audit_log_in, open_data_folder, tokens_in

    log_from(logging.INFO)
    file = load_platform(platform, overrides or (), endpoints)
    certificate = certificate_of(tls_cert, tls_key)
    tokens, audit = tokens_in(data), audit_log_in(data)
    network = rules(host, allowed_host or (), certificate, insecure=insecure_network, tokens=tokens, audit=audit)
    listener = _listen(host, port)
    stop_listener = _listen_for_stop(host, stop_port, listener.getsockname()[1])
    folder = open_data_folder(data)
    # uvicorn raises the signal again when it has ended; it must then not kill us before the series is put together.
    heed_one_interrupt()
    catalogue = open_catalogue(folder.resonators, folder.sequences, resonators, folder.presets)
    engine = start_engine(file, JobRecords(folder.jobs), library(folder.models), catalogue)
    try:
        context, limits = create_context(engine, folder), network.limits
        server = Server(create_api(context, network), engine, limits, certificate)
        scheme = "http" if certificate is None else "https"
        with stop_server(create_stop_api(context, network), stop_listener, limits, certificate):
            print(f"listening on {scheme}://{_address(host, listener)}", flush=True)
            print(f"stop on {scheme}://{_address(host, stop_listener)}/stop", flush=True)
            server.run(sockets=[listener])
    except KeyboardInterrupt:
        pass
    finally:
        engine.close()


def _listen_for_stop(host: str, asked: int | None, main: int) -> socket.socket:
    """On the port that was asked for, else on the one after the main one, else on any that is free."""
    if asked is not None:
        return _listen(host, asked, "--stop-port")
    try:
        return _listen(host, main + 1 if main < 65535 else 0)
    except InputError:
        return _listen(host, 0)


def _listen(host: str, port: int, option: str = "--port") -> socket.socket:
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        # With the protocol named asyncio sends answers without delay (TCP_NODELAY); else many wait for 40 ms.
        listener = socket.socket(family, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(128)
    except (OSError, UnicodeError) as error:  # UnicodeError: a name that DNS cannot hold
        why = getattr(error, "strerror", None) or str(error)
        raise InputError(
            "cannot listen", where=f"{host}:{port}", why=why, remedy=f"choose another {option} or --host"
        ) from None
    return listener


def _address(host: str, listener: socket.socket) -> str:
    return f"{f'[{host}]' if ':' in host else host}:{listener.getsockname()[1]}"
