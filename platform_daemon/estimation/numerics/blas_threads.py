"""A fit runs on one core; who fits many records shares them out among threads or processes."""

from __future__ import annotations

from functools import cache

from threadpoolctl import threadpool_limits


@cache
def one_thread_for_products() -> None:
    """Keep BLAS from starting threads, once per process: for matrices of a dozen columns waking them costs more than
    the work, and while they wait they take the core from other fits.
    """
    threadpool_limits(1, user_api="blas")
