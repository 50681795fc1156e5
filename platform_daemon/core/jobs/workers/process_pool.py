"""Several worker processes that share their tasks; a task waits until one of them is free."""

from __future__ import annotations

import queue
import threading

from .bounds import TaskCancelled
from .limits import WorkerLimits
from .process import WorkerProcess
from .task_executor import ProgressCallback, ResultT, Task

_POLL_S = 0.05


class ProcessPool:
    """A TaskExecutor of `size` worker processes, each started when it is first needed.

    name: of the processes, for the log; nice: niceness that is added to theirs.
    """

    def __init__(self, name: str, size: int, limits: WorkerLimits, *, nice: int) -> None:
        self._workers = [WorkerProcess(f"{name}-{k}", limits, nice) for k in range(size)]
        self._free: queue.LifoQueue[WorkerProcess] = queue.LifoQueue()  # the one used last has its kernels loaded
        for worker in reversed(self._workers):
            self._free.put(worker)

    def run(self, kind: str, task: Task[ResultT], progress: ProgressCallback, cancel: threading.Event) -> ResultT:
        """See TaskExecutor."""
        worker = self._acquire(cancel)
        try:
            return worker.run(kind, task, progress, cancel)
        finally:
            self._free.put(worker)

    def close(self) -> None:
        """See TaskExecutor."""
        for worker in self._workers:
            worker.close()

    def _acquire(self, cancel: threading.Event) -> WorkerProcess:
        while True:
            try:
                return self._free.get(timeout=_POLL_S)
            except queue.Empty:
                if cancel.is_set():
                    raise TaskCancelled from None
