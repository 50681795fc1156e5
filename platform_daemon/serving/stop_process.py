"""The process of the port that does nothing but stop: small, and nobody can keep it busy with anything else."""

from __future__ import annotations

import contextlib
import os
import socket

from platform_daemon.api import create_stop_api, served
from platform_daemon.link import Stopper

from .child import READY, Life
from .logs import LOGS, keep_log
from .options import ServeOptions
from .rules import rules_for

_NICE = -10


def run_stop(options: ServeOptions, life: Life, sockets: tuple[int, ...]) -> None:
    """Until it is told to end.  Raises InputError, OSError."""
    with contextlib.suppress(PermissionError):  # most accounts may not; then it waits its turn like all others
        os.setpriority(os.PRIO_PROCESS, 0, _NICE)
    network, certificate = rules_for(options)
    (listener,) = (socket.socket(fileno=number) for number in sockets)
    if not life.wait_to_go():
        return
    app = create_stop_api(Stopper(options.data).outputs_off, network)
    life.follow()
    keep_log(options.data / LOGS, "stop")
    with served(app, listener, network.limits, certificate) as server:
        life.say(READY)
        server.wait()
