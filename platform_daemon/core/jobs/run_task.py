"""Running a task of a job on the executor of its engine."""

from __future__ import annotations

import threading
from typing import TypeVar

import structlog

from .jobs import AnyJob, Cancelled
from .workers.bounds import TaskCancelled, WorkerLost
from .workers.task_executor import Task, TaskExecutor, ignore_progress

log = structlog.get_logger()
ResultT = TypeVar("ResultT")
_TRIES = 3


def run_task(executor: TaskExecutor, kind: str, task: Task[ResultT], job: AnyJob) -> ResultT:
    """The result of a task; its progress is that of the job, and the cancellation of the job cancels it.

    Raises Cancelled, and what the task raises.
    """
    try:
        return executor.run(kind, task, job.at, job.cancel_requested)
    except TaskCancelled:
        raise Cancelled from None


def run_task_with_retry(executor: TaskExecutor, kind: str, task: Task[ResultT]) -> ResultT:
    """The result of a task, which is run again if its process dies, twice at most.

    Raises what the task raises, WorkerLost after the third death.
    """
    for left in reversed(range(_TRIES)):
        try:
            return executor.run(kind, task, ignore_progress, threading.Event())
        except WorkerLost as error:
            if not left:
                raise
            log.warning("task_run_again", kind=kind, error=str(error))
    raise AssertionError
