"""One process that computes: started when it is first needed, killed to stop, started anew when it has grown."""

from __future__ import annotations

import multiprocessing
import pickle
import threading
import time
from multiprocessing.connection import Connection
from typing import Any

import structlog

from .bounds import Bounds, Stopped, lost, too_large, too_long
from .child import MB, Brought, Failed, Told, serve
from .computer import ResultT, Task, Tell
from .limits import WorkerLimits

log = structlog.get_logger()
_LAST_BREATH_S = 1.0  # from the end of its pipe to its own
_STEP_S = 0.05  # how soon it heeds that somebody wants it to stop
_GROWN = 600 * MB  # resident; kernels and what they need are 250 MB


class WorkerProcess:
    """See Computer.  For several threads, which wait for each other.

    name: of the process, for the log; nice: how much it steps back behind others.
    """

    def __init__(self, name: str, limits: WorkerLimits, nice: int) -> None:
        self._name, self._limits, self._nice = name, limits, nice
        self._lock = threading.Lock()
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None
        self._closed = False

    @property
    def pid(self) -> int | None:
        """Of the process, None: there is none now."""
        process = self._process
        return None if process is None else process.pid

    def compute(self, kind: str, task: Task[ResultT], tell: Tell, stop: threading.Event) -> ResultT:
        """See Computer."""
        bounds = self._limits.of(kind).here()
        while not self._lock.acquire(timeout=_STEP_S):
            if stop.is_set():
                raise Stopped
        try:
            return self._computed(kind, task, tell, stop, bounds)
        finally:
            self._lock.release()

    def close(self) -> None:
        """Kill it.  Idempotent."""
        self._closed = True
        process = self._process
        if process is not None:
            process.kill()
            process.join()

    def _computed(self, kind: str, task: Task[ResultT], tell: Tell, stop: threading.Event, bounds: Bounds) -> ResultT:
        until_s, finished = time.monotonic() + bounds.time_s, False
        try:
            pipe = self._running()
            pipe.send_bytes(pickle.dumps((bounds.memory_mb, task)))
            while True:
                if stop.is_set() or self._closed:
                    raise Stopped
                if time.monotonic() > until_s:
                    raise too_long(kind, bounds)
                if not pipe.poll(_STEP_S):
                    continue
                answer = pickle.loads(pipe.recv_bytes())
                if isinstance(answer, Told):
                    tell(answer.done, answer.what)
                    continue
                finished = True
                value: ResultT = self._outcome(kind, answer, bounds)
                return value
        except (EOFError, OSError):
            code = self._ended(_LAST_BREATH_S)
            if self._closed:
                raise Stopped from None
            raise lost(kind, bounds, code) from None
        except BaseException:
            if not finished:
                self._ended()
            raise

    def _outcome(self, kind: str, answer: Brought | Failed, bounds: Bounds) -> Any:
        if answer.resident > _GROWN:  # what it took it gives back
            self._ended()
        if isinstance(answer, Brought):
            return answer.value
        if answer.error is not None:
            raise answer.error
        self._ended()
        if answer.memory:
            raise too_large(kind, bounds)
        log.error("worker_error", worker=self._name, kind=kind, error=answer.unforeseen)
        raise RuntimeError(answer.unforeseen)

    def _running(self) -> Connection:
        if self._pipe is not None and self._process is not None and self._process.is_alive():
            return self._pipe
        self._ended()
        # Not forked: the process that asks has threads and open devices.
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(theirs, self._nice), name=self._name, daemon=True)
        self._process.start()
        theirs.close()
        return self._pipe

    def _ended(self, patience_s: float = 0.0) -> int | None:
        """Its exit code, None: it lived on after `patience_s` and was killed, or there was none."""
        process, self._process = self._process, None
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
