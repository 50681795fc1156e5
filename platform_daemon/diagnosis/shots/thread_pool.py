"""A thread pool over shots; BLAS is limited to one thread, because its own threads would only compete."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from threading import Event
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

Item = TypeVar("Item")
Result = TypeVar("Result")


class InlineExecutor(Executor):
    """An executor that runs each task at once in the calling thread.

    A task of a pool uses it, because it would deadlock if it waited for another thread of that pool.
    """

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run the task and return its finished future."""
        done: Future[Any] = Future()
        try:
            done.set_result(fn(*args, **kwargs))
        except Exception as error:  # handed on by the future, as every executor does
            done.set_exception(error)
        return done


class StoppedError(RuntimeError):
    """What these tasks belong to is of no use any more."""


class StoppableExecutor(Executor):
    """It hands tasks on to another executor until it is stopped; further ones raise StoppedError."""

    def __init__(self, executor: Executor) -> None:
        self._executor, self._stopped = executor, Event()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """As of the other one.  Raises StoppedError."""
        self._still_of_use()
        return self._executor.submit(self._run, fn, *args, **kwargs)

    def stop(self) -> None:
        """No further task, of those handed on only what runs already."""
        self._stopped.set()

    def _run(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
        self._still_of_use()
        return fn(*args, **kwargs)

    def _still_of_use(self) -> None:
        if self._stopped.is_set():
            raise StoppedError("the search was stopped, because its result is of no use any more")


@contextmanager
def shot_pool() -> Iterator[Executor]:
    """One thread per core; an exception such as Ctrl-C does not wait for running tasks."""
    with threadpool_limits(1, user_api="blas"), _threads() as pool:
        yield pool


def beside_each_other(
    task: Callable[[Item], Result], items: Iterable[Item], *, at_once: int | None = None
) -> list[Result]:
    """Results of tasks that wait for a pool most of the time, so that one uses the cores while another one cannot.

    Each has a thread of its own, because a task would deadlock if it waited for its own pool.  The first one in order
    that fails raises.

    at_once: how many run beside each other; None: one per core.
    """
    with _threads(at_once) as threads:
        return list(threads.map(task, items))


@contextmanager
def _threads(count: int | None = None) -> Iterator[Executor]:
    pool = ThreadPoolExecutor(count or len(os.sched_getaffinity(0)))
    try:
        yield pool
    except StoppedError:
        pool.shutdown(cancel_futures=True)  # what still runs ends with its next task
        raise
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()
