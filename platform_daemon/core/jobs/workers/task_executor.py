"""The interface of what executes tasks, and the executor that needs no other process."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

from .bounds import TaskCancelled

ResultT_co = TypeVar("ResultT_co", covariant=True)
ResultT = TypeVar("ResultT")
ProgressCallback = Callable[[float, str], None]
"""Takes how much of a task is done, in the task's own unit, and what it does now."""


def ignore_progress(done: float, what: str) -> None:
    """A ProgressCallback for callers that show no progress."""


class Task(Protocol[ResultT_co]):
    """A unit of computation.  It and its result are pickled where another process executes it."""

    def __call__(self, progress: ProgressCallback, /) -> ResultT_co:
        """Compute.  `progress` may be called between steps, and may raise.  Raises PlatformError."""


@dataclass(frozen=True)
class Call(Generic[ResultT]):
    """A function with its arguments, as a task that reports no progress.

    Example: `executor.run("preview", Call(sum, ([1, 2, 3],)), ignore_progress, threading.Event())` returns 6.
    """

    function: Callable[..., ResultT]
    arguments: tuple[Any, ...] = ()
    named: Mapping[str, Any] = field(default_factory=dict)

    def __call__(self, progress: ProgressCallback, /) -> ResultT:
        """Raises what the function raises."""
        return self.function(*self.arguments, **self.named)


class TaskExecutor(Protocol):
    """Executes tasks, one after the other or several at once; may be called from several threads."""

    def run(self, kind: str, task: Task[ResultT], progress: ProgressCallback, cancel: threading.Event) -> ResultT:
        """Execute a task and return its result.

        kind: of the work, which selects its limits (see WorkerLimits); progress: is called while the task runs;
        cancel: ends the task once it is set.  Raises TaskCancelled, OverBounds, WorkerLost, and what the task raises.
        """

    def close(self) -> None:
        """Take no more tasks, and cancel those that run.  Idempotent."""


class InProcessExecutor:
    """A TaskExecutor without another process.  A task is cancelled where it reports progress; it has no limits."""

    def run(self, kind: str, task: Task[ResultT], progress: ProgressCallback, cancel: threading.Event) -> ResultT:
        """See TaskExecutor."""

        def progress_or_cancel(done: float, what: str) -> None:
            if cancel.is_set():
                raise TaskCancelled
            progress(done, what)

        return task(progress_or_cancel)

    def close(self) -> None:
        """See TaskExecutor."""
