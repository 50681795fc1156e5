"""The services of the hardware process over the local socket."""

from __future__ import annotations

import threading
from functools import partial
from pathlib import Path
from typing import Any, cast

from drivers.errors import InputError
from platform_daemon.core.schemas.rpc import RpcCall
from platform_daemon.core.schemas.stop import StopReport

from .address import NAME, connected
from .errors import away, error_from_wire, processes_differ
from .framing import JsonLineConnection
from .job_view import JobView
from .platform_service import PlatformService, Repeat
from .response_cache import FinishedJobCache, ResponseCache
from .stopping import AWAY_S, PATIENCE_S, Stopper
from .wire import methods

MAX_IDLE = 16  # connections


class PlatformServiceProxy:
    """See PlatformService: every method of the contract is forwarded by its name; a few know more than that.

    For any number of threads: each call has a connection of its own.  `service(name)` has the service of a feature.
    Every method may raise HardwareAway, and ProcessesDiffer where the other process is of another version.
    """

    def __init__(self, folder: Path, patience_s: float = PATIENCE_S, away_s: float = AWAY_S) -> None:
        self._path, self._patience_s = folder / NAME, patience_s
        self._stopper = Stopper(folder, away_s=away_s)
        self._idle: list[JsonLineConnection] = []
        self._lock = threading.Lock()
        self._responses, self._finished = ResponseCache(), FinishedJobCache()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in methods():
            raise AttributeError(name)
        return partial(self._forward, name)

    def service(self, name: str) -> Any:
        """The service of a feature, whose contract the feature names."""
        return _FeatureServiceProxy(self, name)

    def jobs(self, kind: str, identifiers: tuple[str, ...]) -> tuple[JobView, ...]:
        """See JobService; jobs that have ended are kept here."""
        known = {each: job for each in identifiers if (job := self._finished.get(kind, each)) is not None}
        missing = tuple(each for each in identifiers if each not in known)
        if missing:
            for job in self._forward("jobs", kind, missing):
                self._finished.keep(job)
                known[job.identifier] = job
        return tuple(known[each] for each in identifiers)

    def job(self, kind: str, identifier: str) -> JobView:
        """See JobService."""
        return self.jobs(kind, (identifier,))[0]

    def resume(self, kind: str, identifier: str) -> JobView:
        """See PlatformService."""
        try:
            return cast(JobView, self._forward("resume", kind, identifier))
        finally:
            self._finished.forget(kind, identifier)

    def outputs_off(self) -> StopReport:
        """See PlatformService, and Stopper for a process that does not answer."""
        try:
            return self._stopper.outputs_off()
        finally:
            self.invalidate()

    def invalidate(self) -> None:
        """Invalidate the cache of responses, because a listener is about to receive an event."""
        self._responses.invalidate()

    def close(self) -> None:
        """Close the idle connections.  Idempotent."""
        with self._lock:
            for each in self._idle:
                each.close()
            self._idle.clear()

    def _forward(self, method: str, *arguments: Any) -> Any:
        repeat = methods()[method].repeat
        if repeat is Repeat.QUERY:
            return self._responses.answer((method, *arguments), lambda: self._call(method, *arguments))
        try:
            return self._call(method, *arguments)
        finally:
            if repeat is Repeat.COMMAND:
                self.invalidate()

    def _call(self, method: str, *arguments: Any) -> Any:
        line = self._free_line()
        try:
            line.send(RpcCall(method=method, arguments=arguments))
            answer = line.answer()
        except OSError as error:
            line.close()
            raise away(str(error) or type(error).__name__) from None
        except ValueError as error:
            line.close()
            raise processes_differ(method, error) from error
        except BaseException:
            line.close()
            raise
        if answer is None:
            line.close()
            raise away("it ended before it answered")
        self._give_back(line)
        if answer.error is not None:
            raise error_from_wire(answer.error)
        try:
            return methods()[method].read_answer(answer.value, arguments)
        except (ValueError, TypeError, LookupError, InputError) as error:
            raise processes_differ(method, error) from error

    def _free_line(self) -> JsonLineConnection:
        """An idle connection that is still open, else a new one.  Raises HardwareAway."""
        while True:
            with self._lock:
                line = self._idle.pop() if self._idle else None
            if line is None:
                break
            if not line.is_stale():
                return line
            line.close()
        try:
            return JsonLineConnection(connected(self._path, self._patience_s))
        except OSError as error:
            raise away(error.strerror or str(error)) from None

    def _give_back(self, line: JsonLineConnection) -> None:
        with self._lock:
            if len(self._idle) < MAX_IDLE:
                self._idle.append(line)
                return
        line.close()


class _FeatureServiceProxy:
    """Forwards the methods of a feature's service."""

    def __init__(self, proxy: PlatformServiceProxy, name: str) -> None:
        self._proxy, self._name = proxy, name

    def __getattr__(self, name: str) -> Any:
        method = f"{self._name}.{name}"
        if name.startswith("_") or method not in methods():
            raise AttributeError(name)
        return partial(self._proxy._forward, method)  # noqa: SLF001 of the same module


def connect(folder: Path) -> PlatformService:
    """The platform service of the daemon whose data are in `folder`."""
    return cast(PlatformService, PlatformServiceProxy(folder))
