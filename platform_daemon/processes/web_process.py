"""The web process: REST and stored data; it reaches the hardware process over the local socket."""

from __future__ import annotations

import socket
import threading
import warnings

import structlog

from drivers.errors import PlatformError
from platform_daemon.core.hardware.catalogue import open_catalogue
from platform_daemon.core.hardware.latency import reduce_latency
from platform_daemon.core.jobs.workers.bounds import TaskCancelled
from platform_daemon.core.jobs.workers.limits import WorkerLimits
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor, ignore_progress
from platform_daemon.core.recordings.data_folder import data_paths
from platform_daemon.core.service.analysis_keeper import AnalysisKeeper
from platform_daemon.core.service.proxy import PlatformServiceProxy
from platform_daemon.core.state.event_journal import EventJournal
from platform_daemon.core.state.logs import LOGS, keep_log
from platform_daemon.core.web.network.http_server import running_server
from platform_daemon.core.web.server import create_api
from platform_daemon.features.alarms.caller import Caller
from platform_daemon.features.fit.online import Warmth
from platform_daemon.features.tune.presets import TunedPresets

from .assembly import create_context
from .child import CHECKED, READY, ParentLink
from .options import ServeOptions
from .process import lower_priority
from .rules import rules_for

log = structlog.get_logger()
_NICE = 5
PICTURES_AFTER_S = 60.0  # it takes three seconds of a processor, which the first shots may need
# FastAPI passes pydantic an alias that has no effect; on the terminal the warning would worry users.
_NOISE = "The 'alias' attribute with value 'body'"


def run_web(options: ServeOptions, parent: ParentLink, sockets: tuple[int, ...]) -> None:
    """Run the process until it receives the signal to end.  Raises InputError, OSError."""
    lower_priority(_NICE)
    warnings.filterwarnings("ignore", message=_NOISE)
    network, certificate = rules_for(options)
    bounds = WorkerLimits().changed(options.worker_limits)
    caller = Caller(options.alarm_command, options.alarm_url)
    (listener,) = (socket.socket(fileno=number) for number in sockets)
    parent.report(CHECKED)
    if not parent.wait_to_go():
        return
    parent.end_with_parent()
    keep_log(options.data / LOGS, "web")
    folder = data_paths(options.data)
    catalogue = open_catalogue(folder.resonators, folder.sequences, options.resonators, TunedPresets(folder.presets))
    events = EventJournal(folder.events)
    idle_s = None if options.alarm_idle_h is None else 3600 * options.alarm_idle_h
    context = create_context(PlatformServiceProxy(options.data), folder, catalogue, bounds, events.tell, caller, idle_s)
    with running_server(
        create_api(context, network, options.root_path),
        listener,
        limits=network.limits,
        certificate=certificate,
        max_connections=network.limits.connections,
    ) as server:
        keeper = AnalysisKeeper(context.analyses)
        pictures = threading.Timer(PICTURES_AFTER_S, _prepare_pictures, (context.executor,))
        pictures.name, pictures.daemon = "pictures", True
        try:
            reduce_latency()  # trends of many shots are computed in threads of this process
            parent.report(READY)
            pictures.start()
            server.wait()
        finally:
            pictures.cancel()
            keeper.close()
            context.close()
            events.close()


def _prepare_pictures(executor: TaskExecutor) -> None:
    """Load what the first picture needs while nobody waits for it: matplotlib here, kernels where fits are computed."""
    from platform_daemon.features.fit.ring_down_figure import prepare_pictures

    prepare_pictures()
    try:
        executor.run("planning", Warmth(loads_only=True), ignore_progress, threading.Event())
    except (PlatformError, TaskCancelled) as error:  # the first picture takes longer then, or says why there is none
        log.warning("pictures_not_prepared", error=str(error))
