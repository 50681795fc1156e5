"""The memory and time that a task may take, and the errors of a task that was ended."""

from __future__ import annotations

import resource
from dataclasses import dataclass, replace

from drivers.errors import InputError, PlatformError

from .child import MB


@dataclass(frozen=True)
class Bounds:
    """memory_mb: address space of the worker process, in 10^6 bytes; time_s: from the start of the task to its end."""

    memory_mb: int
    time_s: float

    def here(self) -> Bounds:
        """With no more memory than this process itself may have (`ulimit -v`, `LimitAS=` of systemd)."""
        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        return self if hard == resource.RLIM_INFINITY else replace(self, memory_mb=min(self.memory_mb, hard // MB))


class TaskCancelled(Exception):
    """The task was cancelled, and its process has ended."""


class OverBounds(InputError):
    """The task took more memory or time than work of its kind may; it was stopped, and left nothing behind."""

    title = "Too much work"
    http_status = 413
    nothing_moved = False


class WorkerLost(PlatformError):
    """The process that computed the task died: of an error of its own, or killed from outside."""

    title = "Worker lost"


def too_long(kind: str, bounds: Bounds) -> OverBounds:
    """The error of a task that was ended after the time it may take."""
    return OverBounds(
        f"the {kind} took longer than {bounds.time_s:g} s",
        why="that is the limit of time of its kind",
        remedy=f"ask for less (fewer shots, a shorter window), or start the daemon with --worker-limit {kind}:SECONDSs",
    )


def too_large(kind: str, bounds: Bounds) -> OverBounds:
    """The error of a task that needs more memory than it may have."""
    ask = f"ask for less (fewer shots, a shorter window), or start the daemon with --worker-limit {kind}:MEGABYTESMB"
    return OverBounds(
        f"the {kind} needs more than {bounds.memory_mb} MB of memory",
        why="that is the limit of memory of its kind",
        remedy=ask,
    )


def lost(kind: str, bounds: Bounds, code: int | None) -> WorkerLost:
    """The error of a task whose process died; code: exit code, None: unknown."""
    how = f"by signal {-code}" if code is not None and code < 0 else f"with exit code {code}"
    return WorkerLost(
        f"the process that computed the {kind} died {how}",
        why=f"it was killed, or wanted more than the {bounds.memory_mb} MB that it may have",
        remedy="ask again; if it happens again, ask for less, or report it with the log",
    )
