"""The process that serves the web: REST, reading what is stored; it asks the hardware process over the local socket."""

from __future__ import annotations

import socket

from platform_daemon.alarms import Caller
from platform_daemon.api import (
    AnalysisKeeper,
    certificate_of,
    create_api,
    create_stop_api,
    rules,
    served,
)
from platform_daemon.app import create_context
from platform_daemon.engine import open_catalogue
from platform_daemon.link import RemoteHardware
from platform_daemon.store import EventJournal, audit_log_in, data_paths, tokens_in
from platform_daemon.workers import WorkerLimits

from .child import CHECKED, READY, Life
from .logs import LOGS, keep_log
from .options import ServeOptions
from .process import step_back

_NICE = 5


def run_web(options: ServeOptions, life: Life, sockets: tuple[int, ...]) -> None:
    """Until it is told to end.  Raises InputError, OSError."""
    step_back(_NICE)
    certificate = certificate_of(options.tls_cert, options.tls_key)
    tokens, audit = tokens_in(options.data), audit_log_in(options.data)
    network = rules(
        options.host,
        options.allowed_hosts,
        certificate,
        insecure=options.insecure_network,
        tokens=tokens,
        audit=audit,
    )
    bounds = WorkerLimits().changed(options.worker_limits)
    caller = Caller(options.alarm_command, options.alarm_url)
    main, stop = (socket.socket(fileno=number) for number in sockets)
    life.say(CHECKED)
    if not life.wait_to_go():
        return
    life.follow()
    keep_log(options.data / LOGS, "web")
    folder = data_paths(options.data)
    catalogue = open_catalogue(folder.resonators, folder.sequences, options.resonators, folder.presets)
    events = EventJournal(folder.events)
    idle_s = None if options.alarm_idle_h is None else 3600 * options.alarm_idle_h
    context = create_context(RemoteHardware(options.data), folder, catalogue, bounds, events.tell, caller, idle_s)
    limits = network.limits
    with (
        served(create_stop_api(context, network), stop, limits, certificate),
        served(create_api(context, network), main, limits, certificate) as server,
    ):
        keeper = AnalysisKeeper(context)
        try:
            life.say(READY)
            server.wait()
        finally:
            keeper.close()
            context.close()
            events.close()
