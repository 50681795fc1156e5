"""Several workers for what many ask for at once; who finds none free waits, and not for ever."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable

from drivers.errors import PlatformError

from .bounds import Stopped
from .computer import Computer, ResultT, Task, Tell

_STEP_S = 0.05


class Pool:
    """See Computer.

    computers: those that share the work; patience_s: how long somebody waits for a free one; busy: the error then.
    """

    def __init__(self, computers: list[Computer], patience_s: float, busy: Callable[[], PlatformError]) -> None:
        self._all, self._patience_s, self._busy = computers, patience_s, busy
        self._free: queue.LifoQueue[Computer] = queue.LifoQueue()  # the one used last is warm
        for each in reversed(computers):
            self._free.put(each)

    def compute(self, kind: str, task: Task[ResultT], tell: Tell, stop: threading.Event) -> ResultT:
        """See Computer.  Raises also what `busy` makes."""
        computer = self._taken(stop)
        try:
            return computer.compute(kind, task, tell, stop)
        finally:
            self._free.put(computer)

    def close(self) -> None:
        """See Computer."""
        for each in self._all:
            each.close()

    def _taken(self, stop: threading.Event) -> Computer:
        until_s = time.monotonic() + self._patience_s
        while True:
            try:
                return self._free.get(timeout=_STEP_S)
            except queue.Empty:
                if stop.is_set():
                    raise Stopped from None
                if time.monotonic() > until_s:
                    raise self._busy() from None
