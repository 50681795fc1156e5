"""Threads over shots: the numerical libraries are kept from starting threads of their own, which would only wait."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

from threadpoolctl import threadpool_limits


class InThisThread(Executor):
    """For work on one shot within a thread of a pool, which must not wait for another thread of it."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Do it at once."""
        done: Future[Any] = Future()
        try:
            done.set_result(fn(*args, **kwargs))
        except Exception as error:  # handed on by the future, as every executor does
            done.set_exception(error)
        return done


@contextmanager
def shot_pool() -> Iterator[Executor]:
    """A thread per core; an exception, Ctrl-C for one, does not wait for what they are at."""
    with threadpool_limits(1, user_api="blas"):
        pool = ThreadPoolExecutor(len(os.sched_getaffinity(0)))
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        pool.shutdown()
