"""What a job has computed by whoever computes for its engine."""

from __future__ import annotations

import threading
from typing import TypeVar

import structlog

from platform_daemon.workers import Computer, Stopped, Task, WorkerLost

from .jobs import AnyJob, Cancelled

log = structlog.get_logger()
ResultT = TypeVar("ResultT")
_TRIES = 3


def computed(computer: Computer, kind: str, task: Task[ResultT], job: AnyJob) -> ResultT:
    """What the task brings; the job tells how far it is, and its cancellation stops it.

    Raises Cancelled, and what the task raises.
    """
    try:
        return computer.compute(kind, task, job.at, job.cancel_requested)
    except Stopped:
        raise Cancelled from None


def computed_surely(computer: Computer, kind: str, task: Task[ResultT]) -> ResultT:
    """What the task brings, also if the process that computes it dies once or twice.  Raises what the task raises."""
    for left in reversed(range(_TRIES)):
        try:
            return computer.compute(kind, task, _silent, threading.Event())
        except WorkerLost as error:
            if not left:
                raise
            log.warning("computed_again", kind=kind, error=str(error))
    raise AssertionError


def _silent(done: float, what: str) -> None:
    pass
