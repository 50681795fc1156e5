"""Who computes, as those see it who ask."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, Protocol, TypeVar

from .bounds import Stopped

ResultT_co = TypeVar("ResultT_co", covariant=True)
ResultT = TypeVar("ResultT")
Tell = Callable[[float, str], None]
"""(how much is done, what is done now)"""


class Task(Protocol[ResultT_co]):
    """What is computed.  It and its result are pickled where another process computes."""

    def __call__(self, tell: Tell) -> ResultT_co:
        """Compute; `tell` may be called between steps, and may raise.  Raises PlatformError."""


@dataclass(frozen=True)
class Call(Generic[ResultT]):
    """A function with its arguments, as a task that says nothing while it computes."""

    function: Callable[..., ResultT]
    arguments: tuple[Any, ...] = ()
    named: Mapping[str, Any] = field(default_factory=dict)

    def __call__(self, tell: Tell) -> ResultT:
        """Raises what the function raises."""
        return self.function(*self.arguments, **self.named)


class Computer(Protocol):
    """Computes."""

    def compute(self, kind: str, task: Task[ResultT], tell: Tell, stop: threading.Event) -> ResultT:
        """What the task brings.  kind: of the work, for its limits; tell: is told how far it is; stop: ends it.

        Raises Stopped, OverBounds, WorkerLost, and what the task raises.
        """

    def close(self) -> None:
        """No more work.  Idempotent."""


class InThisProcess:
    """See Computer.  A task stops where it tells how far it is; nothing bounds it."""

    def compute(self, kind: str, task: Task[ResultT], tell: Tell, stop: threading.Event) -> ResultT:
        """See Computer."""

        def heed(done: float, what: str) -> None:
            if stop.is_set():
                raise Stopped
            tell(done, what)

        return task(heed)

    def close(self) -> None:
        """See Computer."""
