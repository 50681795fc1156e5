"""The parent: it starts the processes, restarts one that dies or hangs, and ends all in order.  It opens no device."""

from __future__ import annotations

import select
import socket
import time
from collections.abc import Callable

import structlog

from platform_daemon.core.state.logs import LOGS, keep_log

from .child import CHECKED, READY, Child
from .options import ServeOptions
from .respawn import respawn_options

log = structlog.get_logger()
_END_HARDWARE_S = 90.0  # longer than outputs off with devices that do not answer, and than a series put together
_END_WEB_S = 10.0
_SHORT_LIFE_S = 10.0  # a process that ends sooner waits before it is restarted
_MIN_BACKOFF_S, _MAX_BACKOFF_S = 0.5, 30.0
_POLL_S, _RESTART_POLL_S = 1.0, 0.05  # the second while a process waits to be restarted


class Daemon:
    """The processes `hardware`, `web` and `stop`.

    sockets: what web and stop listen on; they stay open while a process is restarted, so that clients wait and are not
    refused.
    """

    def __init__(self, options: ServeOptions, sockets: tuple[socket.socket, socket.socket]) -> None:
        self._options = options
        self._files: tuple[int, ...] = ()  # descriptors that the options of restarted processes name
        self._sockets = dict(zip(("web", "stop"), sockets, strict=False))
        self._children: dict[str, Child] = {}
        self._backoff_s: dict[str, float] = {}
        self._restart_at_s: dict[str, float] = {}  # monotonic

    def start(self) -> None:
        """Start all processes, at the same time.  Raises StartFailed."""
        restart_options = respawn_options(self._options)
        web = self._spawn("web")
        hardware = self._spawn("hardware")
        stop = self._spawn("stop")
        web.wait_for(CHECKED)  # before any device is opened: its options may be wrong
        hardware.go()
        hardware.wait_for(READY)  # before the web answers: the data folder may be another daemon's
        stop.go()
        web.go()
        stop.wait_for(READY)
        web.wait_for(READY)
        self._options, self._files = restart_options
        keep_log(self._options.data / LOGS, "daemon")

    def run(self, heartbeat: Callable[[], None] = lambda: None) -> None:
        """Watch the processes until an interrupt; `heartbeat` is called about every second while all of them work."""
        while True:
            timeout_s = _RESTART_POLL_S if self._restart_at_s else _POLL_S
            ended = select.select([*self._children.values()], [], [], timeout_s)[0]
            for child in ended:
                self._handle_exit(child)
            for name in [name for name, due_s in self._restart_at_s.items() if due_s <= time.monotonic()]:
                self._restart(name)
            hanging = [child for child in self._children.values() if child.hangs()]
            for child in hanging:  # one that may have power on is ended sooner, by its guard
                log.error("process_hangs", process=child.name)
                child.kill()
            if not ended and not hanging and not self._restart_at_s:
                heartbeat()

    def end(self) -> None:
        """Outputs off and series completed first, the stop port last.  Idempotent."""
        for name, patience_s in (("hardware", _END_HARDWARE_S), ("web", _END_WEB_S), ("stop", _END_WEB_S)):
            if name in self._children:
                self._children.pop(name).end(patience_s)

    def _spawn(self, name: str) -> Child:
        sockets = [self._sockets[name].fileno()] if name in self._sockets else []
        child = Child(name, self._options, sockets=sockets, files=self._files)
        self._children[name] = child
        return child

    def _restart(self, name: str) -> None:
        """A computer without memory or descriptors for it now may have them later; the others continue meanwhile."""
        del self._restart_at_s[name]
        try:
            child = self._spawn(name)
        except OSError as error:
            log.error("process_not_started", process=name, error=str(error), again_in_s=_MIN_BACKOFF_S)
            self._restart_at_s[name] = time.monotonic() + _MIN_BACKOFF_S
        else:
            child.go()

    def _handle_exit(self, child: Child) -> None:
        """Schedule the restart: at once, or after a wait that doubles if the process ends soon after its start."""
        lived_s = time.monotonic() - child.started_s
        why = child.exit_reason() or None
        code = self._children.pop(child.name).end(0)
        previous_s = self._backoff_s.get(child.name) if lived_s < _SHORT_LIFE_S else None
        wait_s = 0.0 if previous_s is None else min(_MAX_BACKOFF_S, max(_MIN_BACKOFF_S, 2 * previous_s))
        self._backoff_s[child.name] = wait_s
        self._restart_at_s[child.name] = time.monotonic() + wait_s
        log.error("process_died", process=child.name, code=code, lived_s=round(lived_s, 1), again_in_s=wait_s, why=why)
