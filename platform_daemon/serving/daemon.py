"""The parent: it starts the processes, starts anew what dies or hangs, and ends all in order.  It opens no device."""

from __future__ import annotations

import select
import socket
import time
from collections.abc import Callable

import structlog

from .anew import options_anew
from .child import CHECKED, READY, Child
from .logs import LOGS, keep_log
from .options import ServeOptions

log = structlog.get_logger()
_END_HARDWARE_S = 90.0  # longer than outputs off with devices that do not answer, and than a series put together
_END_WEB_S = 10.0
_SHORT_LIFE_S = 10.0  # a process that has not lived so long waits before it is started again
_SHORTEST_WAIT_S, _LONGEST_WAIT_S = 0.5, 30.0
_LOOK_S = 0.05  # while one waits to be started again


class Daemon:
    """The processes `hardware`, `web` and `stop`.

    sockets: what web and stop listen on; they stay open while a process is started anew, so that clients wait and are
    not refused.
    """

    def __init__(self, options: ServeOptions, sockets: tuple[socket.socket, socket.socket]) -> None:
        self._options = options
        self._files: tuple[int, ...] = ()  # what options name, of those that are started anew
        self._sockets = dict(zip(("web", "stop"), sockets, strict=False))
        self._children: dict[str, Child] = {}
        self._waits_s: dict[str, float] = {}
        self._again_s: dict[str, float] = {}  # when what has died starts again, monotonic

    def start(self) -> None:
        """All processes, each while the others do.  Raises StartFailed."""
        anew = options_anew(self._options)
        web, hardware, stop = self._begun("web"), self._begun("hardware"), self._begun("stop")
        web.wait_for(CHECKED)  # before any device is opened: its options may be wrong
        hardware.go()
        hardware.wait_for(READY)  # before the web answers: the data folder may be another daemon's
        stop.go()
        web.go()
        stop.wait_for(READY)
        web.wait_for(READY)
        self._options, self._files = anew
        keep_log(self._options.data / LOGS, "daemon")

    def run(self, heartbeat: Callable[[], None] = lambda: None) -> None:
        """Until an interrupt; `heartbeat` is called about every second while all processes live."""
        while True:
            ended = select.select([*self._children.values()], [], [], 1.0 if not self._again_s else _LOOK_S)[0]
            for child in ended:
                self._bury(child)
            for name in [name for name, due_s in self._again_s.items() if due_s <= time.monotonic()]:
                self._begin_again(name)
            halted = [child for child in self._children.values() if child.hangs()]
            for child in halted:  # one that has power out is ended sooner, by its guard
                log.error("process_hangs", process=child.name)
                child.kill()
            if not ended and not halted and not self._again_s:
                heartbeat()

    def end(self) -> None:
        """Outputs off and the series put together first, the port for stop last.  Idempotent."""
        for name, patience_s in (("hardware", _END_HARDWARE_S), ("web", _END_WEB_S), ("stop", _END_WEB_S)):
            if name in self._children:
                self._children.pop(name).end(patience_s)

    def _begun(self, name: str) -> Child:
        handed = [self._sockets[name].fileno()] if name in self._sockets else []
        child = self._children[name] = Child(name, self._options, handed, self._files)
        return child

    def _begin_again(self, name: str) -> None:
        """A computer that has no memory or descriptors for it now may have them later: the others go on meanwhile."""
        del self._again_s[name]
        try:
            child = self._begun(name)
        except OSError as error:
            log.error("process_not_started", process=name, error=str(error), again_in_s=_SHORTEST_WAIT_S)
            self._again_s[name] = time.monotonic() + _SHORTEST_WAIT_S
        else:
            child.go()

    def _bury(self, child: Child) -> None:
        """It starts anew at once; one that dies again soon after its start waits longer every time."""
        lived_s = time.monotonic() - child.started_s
        why = child.why() or None
        code = self._children.pop(child.name).end(0)
        soon_again = self._waits_s.get(child.name) if lived_s < _SHORT_LIFE_S else None
        wait_s = 0.0 if soon_again is None else min(_LONGEST_WAIT_S, max(_SHORTEST_WAIT_S, 2 * soon_again))
        self._waits_s[child.name] = wait_s
        self._again_s[child.name] = time.monotonic() + wait_s
        log.error("process_died", process=child.name, code=code, lived_s=round(lived_s, 1), again_in_s=wait_s, why=why)
