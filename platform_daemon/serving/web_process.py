"""The process that serves the web: REST, reading what is stored; it asks the hardware process over the local socket."""

from __future__ import annotations

import socket
import warnings

from platform_daemon.alarms import Caller
from platform_daemon.api import AnalysisKeeper, create_api, served
from platform_daemon.app import create_context
from platform_daemon.engine import open_catalogue, reduce_latency
from platform_daemon.link import RemoteHardware
from platform_daemon.store import EventJournal, data_paths
from platform_daemon.workers import WorkerLimits

from .child import CHECKED, READY, Life
from .logs import LOGS, keep_log
from .options import ServeOptions
from .process import step_back
from .rules import rules_for

_NICE = 5
# FastAPI hands pydantic an alias that it has no use for there; on the terminal it would worry people.
_NOISE = "The 'alias' attribute with value 'body'"


def run_web(options: ServeOptions, life: Life, sockets: tuple[int, ...]) -> None:
    """Until it is told to end.  Raises InputError, OSError."""
    step_back(_NICE)
    warnings.filterwarnings("ignore", message=_NOISE)
    network, certificate = rules_for(options)
    bounds = WorkerLimits().changed(options.worker_limits)
    caller = Caller(options.alarm_command, options.alarm_url)
    (listener,) = (socket.socket(fileno=number) for number in sockets)
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
    with served(create_api(context, network), listener, network.limits, certificate) as server:
        keeper = AnalysisKeeper(context)
        try:
            reduce_latency()  # trends of many shots are computed beside the answers
            life.say(READY)
            server.wait()
        finally:
            keeper.close()
            context.close()
            events.close()
