"""Threads over shots: the numerical libraries are kept from starting threads of their own, which would only wait."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager

from threadpoolctl import threadpool_limits


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
