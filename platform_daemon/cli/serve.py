"""`platform-daemon serve`: the daemon with its REST interface."""

from __future__ import annotations

import contextlib
import logging
import math
import os
import re
import socket
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.interrupts import heed_one_interrupt
from platform_daemon.core.command_line.options import (
    EndpointsOption,
    PlatformOption,
    RealTimeOption,
    SetOption,
    overrides,
)

if TYPE_CHECKING:
    from platform_daemon.processes.daemon import Daemon
    from platform_daemon.processes.options import ServeOptions

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
LimitOption = Annotated[
    list[str] | None,
    typer.Option(
        "--worker-limit", help="Memory or time of a kind of work, as diagnosis:8000MB or fit:600s; may be repeated."
    ),
]
NameOption = Annotated[
    list[str] | None, typer.Option("--allowed-host", help="A further name that clients call it by; may be repeated.")
]
CommandOption = Annotated[
    str | None, typer.Option("--alarm-command", help="Run for each alarm, which it gets as JSON on standard input.")
]
UrlOption = Annotated[str | None, typer.Option("--alarm-url", help="POST each alarm there, as JSON.")]
RootOption = Annotated[str, typer.Option("--root-path", help="Path below which a reverse proxy serves it, as /mmr.")]
IdleOption = Annotated[
    float | None, typer.Option("--alarm-idle-h", help="Raise an alarm when nothing has begun for so long, h.", min=0.01)
]

_SILENCE_S = 60.0  # longer than a process that has died takes to be started again


def serve(
    platform: PlatformOption = "simulated",
    host: HostOption = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port to listen on; 0: any free one.", min=0, max=65535)] = 8212,
    stop_port: StopPortOption = None,
    data: Annotated[Path, typer.Option(help="Folder of recordings and fits.")] = Path("data"),
    resonators: Annotated[Path | None, typer.Option(help="Folder of further resonator files, by name.")] = None,
    set_values: SetOption = None,
    endpoints: EndpointsOption = None,
    real_time: RealTimeOption = False,
    tls_cert: CertificateOption = None,
    tls_key: KeyOption = None,
    insecure_network: InsecureOption = False,
    allowed_host: NameOption = None,
    forget_queue: Annotated[
        bool, typer.Option("--forget-queue", help="Cancel what waited when the daemon ended; else it waits on.")
    ] = False,
    worker_limit: LimitOption = None,
    alarm_command: CommandOption = None,
    alarm_url: UrlOption = None,
    alarm_idle_h: IdleOption = None,
    root_path: RootOption = "",
) -> None:
    """Run the daemon until SIGTERM or Ctrl-C; outputs go off first."""
    from platform_daemon.core.state.logs import log_from
    from platform_daemon.processes.daemon import Daemon
    from platform_daemon.processes.network import listen, listen_for_stop
    from platform_daemon.processes.options import ServeOptions

    if alarm_idle_h is not None and not math.isfinite(alarm_idle_h):
        remedy = "give hours, or leave it out"
        raise InputError(f"{alarm_idle_h:g} h never pass", where="--alarm-idle-h", remedy=remedy)
    if root_path and not re.fullmatch(r"(/[A-Za-z0-9._~-]+)+", root_path):
        remedy = "write it as /mmr, with a slash before it and none after it"
        raise InputError(f"{root_path!r} is no path", where="--root-path", remedy=remedy)
    log_from(logging.INFO)
    options = ServeOptions(
        platform=platform,
        overrides=overrides(platform, set_values, real_time),
        endpoints=endpoints,
        data=data,
        resonators=resonators,
        host=host,
        allowed_hosts=tuple(allowed_host or ()),
        tls_cert=tls_cert,
        tls_key=tls_key,
        insecure_network=insecure_network,
        forget_queue=forget_queue,
        worker_limits=tuple(worker_limit or ()),
        alarm_command=alarm_command,
        alarm_url=alarm_url,
        alarm_idle_h=alarm_idle_h,
        root_path=root_path,
    )
    try:
        options.model_dump_json()
    except ValueError:  # the list of processes and every log would hold it
        remedy = "give names and paths in UTF-8"
        raise InputError("an option holds bytes that are no text", where="serve", remedy=remedy) from None
    with listen(host, port) as listener, listen_for_stop(host, stop_port, listener.getsockname()[1]) as stop_listener:
        # A second signal must not cut short what the first one began: a series is put together.
        heed_one_interrupt()
        ports = {"port": listener.getsockname()[1], "stop_port": stop_listener.getsockname()[1]}
        options = options.model_copy(update=ports)
        _run(Daemon(options, (listener, stop_listener)), options, listener, stop_listener)


def _run(daemon: Daemon, options: ServeOptions, listener: socket.socket, stop_listener: socket.socket) -> None:
    """Until an interrupt.  Raises PlatformError if a process could not start."""
    from platform_daemon.core.guard.notify import Heartbeat, service_manager

    try:
        daemon.start()
        scheme = "http" if options.tls_cert is None else "https"
        main, stop = (f"{scheme}://{_address(options.host, each)}" for each in (listener, stop_listener))
        text = f"listening on {main}\nstop on {stop}/stop\nthe page is {main}/page/\n"
        threading.Thread(target=_say, args=(text,), name="says", daemon=True).start()
        heartbeat = Heartbeat(_SILENCE_S)
        with service_manager(heartbeat.lives):
            daemon.run(heartbeat)
    except KeyboardInterrupt:
        pass
    finally:
        daemon.end()


def _say(text: str) -> None:
    """Print a line; a reader that does not read, a halted terminal or a full disk loses it and blocks nothing.

    The line bypasses the buffer of the stream, whose content is written again at the end.
    """
    with contextlib.suppress(OSError, ValueError):
        os.write(sys.stdout.fileno(), text.encode())


def _address(host: str, listener: socket.socket) -> str:
    return f"{f'[{host}]' if ':' in host else host}:{listener.getsockname()[1]}"
