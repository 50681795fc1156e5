"""One worker process: started when it is first needed, killed to cancel its task, replaced when it has grown."""

from __future__ import annotations

import multiprocessing
import pickle
import threading
import time
from multiprocessing.connection import Connection
from typing import Any

import structlog

from .bounds import Bounds, TaskCancelled, lost, too_large, too_long
from .child import MB, ErrorMessage, ProgressMessage, ResultMessage, run_worker
from .limits import WorkerLimits
from .task_executor import ProgressCallback, ResultT, Task

log = structlog.get_logger()
_EXIT_PATIENCE_S = 1.0  # from the end of its pipe to its own
_POLL_S = 0.05  # how soon a cancellation takes effect
_MAX_IDLE_BYTES = 600 * MB  # resident; kernels and what they need are 250 MB


class WorkerProcess:
    """A TaskExecutor of one process; threads that call it at the same time wait for each other.

    name: of the process, for the log; nice: niceness that is added to its own.
    """

    def __init__(self, name: str, limits: WorkerLimits, nice: int) -> None:
        self._name = name
        self._limits = limits
        self._nice = nice
        self._lock = threading.Lock()
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None
        self._closed = False

    @property
    def pid(self) -> int | None:
        """Of the process, None: there is none now."""
        process = self._process
        return None if process is None else process.pid

    def run(self, kind: str, task: Task[ResultT], progress: ProgressCallback, cancel: threading.Event) -> ResultT:
        """See TaskExecutor."""
        bounds = self._limits.of(kind).here()
        while not self._lock.acquire(timeout=_POLL_S):
            if cancel.is_set():
                raise TaskCancelled
        try:
            return self._run(kind, bounds, task, progress, cancel)
        finally:
            self._lock.release()

    def close(self) -> None:
        """Kill it.  Idempotent."""
        self._closed = True
        process = self._process
        if process is not None:
            process.kill()
            process.join()

    def _run(
        self, kind: str, bounds: Bounds, task: Task[ResultT], progress: ProgressCallback, cancel: threading.Event
    ) -> ResultT:
        until_s = time.monotonic() + bounds.time_s
        answered = False
        try:
            pipe = self._started()
            pipe.send_bytes(pickle.dumps((bounds.memory_mb, task)))
            while True:
                if cancel.is_set() or self._closed:
                    raise TaskCancelled
                if time.monotonic() > until_s:
                    raise too_long(kind, bounds)
                if not pipe.poll(_POLL_S):
                    continue
                message = pickle.loads(pipe.recv_bytes())
                if isinstance(message, ProgressMessage):
                    progress(message.done, message.what)
                    continue
                answered = True
                value: ResultT = self._outcome(kind, message, bounds)
                return value
        except (EOFError, OSError):
            code = self._end(_EXIT_PATIENCE_S)
            if self._closed:
                raise TaskCancelled from None
            raise lost(kind, bounds, code) from None
        except BaseException:
            if not answered:
                self._end()
            raise

    def _outcome(self, kind: str, message: ResultMessage | ErrorMessage, bounds: Bounds) -> Any:
        if message.resident_bytes > _MAX_IDLE_BYTES:  # its end gives the memory back
            self._end()
        if isinstance(message, ResultMessage):
            return message.value
        if message.error is not None:
            raise message.error
        self._end()
        if message.out_of_memory:
            raise too_large(kind, bounds)
        log.error("worker_error", worker=self._name, kind=kind, error=message.unexpected)
        raise RuntimeError(message.unexpected)

    def _started(self) -> Connection:
        if self._pipe is not None and self._process is not None and self._process.is_alive():
            return self._pipe
        self._end()
        # Not forked: the process that starts it has threads and open devices.
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=run_worker, args=(theirs, self._nice), name=self._name, daemon=True)
        self._process.start()
        theirs.close()
        return self._pipe

    def _end(self, patience_s: float = 0.0) -> int | None:
        """End the process; its exit code, None: it was alive after `patience_s` and was killed, or there was none."""
        process = self._process
        self._process = None
        if self._pipe is not None:
            self._pipe.close()
            self._pipe = None
        if process is None:
            return None
        process.join(patience_s)
        alive = process.is_alive()
        process.kill()
        process.join()
        code = None if alive else process.exitcode
        process.close()
        return code
