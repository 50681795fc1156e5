"""The process of the stop port: small, and it answers nothing but stop and health."""

from __future__ import annotations

import contextlib
import os
import socket

from platform_daemon.core.service.stopping import Stopper
from platform_daemon.core.state.logs import LOGS, keep_log
from platform_daemon.core.web.network.http_server import running_server
from platform_daemon.core.web.stop_server import create_stop_api

from .child import READY, ParentLink
from .options import ServeOptions
from .rules import rules_for

_NICE = -10


def run_stop(options: ServeOptions, parent: ParentLink, sockets: tuple[int, ...]) -> None:
    """Run the process until it receives the signal to end.  Raises InputError, OSError."""
    with contextlib.suppress(PermissionError):  # most accounts may not; then it has the usual priority
        os.setpriority(os.PRIO_PROCESS, 0, _NICE)
    network, certificate = rules_for(options)
    (listener,) = (socket.socket(fileno=number) for number in sockets)
    if not parent.wait_to_go():
        return
    app = create_stop_api(Stopper(options.data).outputs_off, network)
    parent.end_with_parent()
    keep_log(options.data / LOGS, "stop")
    with running_server(app, listener, limits=network.limits, certificate=certificate) as server:
        parent.report(READY)
        server.wait()
