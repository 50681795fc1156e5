"""Executors on this machine.  Fits run one thread each: a process per core uses all of them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from typing import Any

_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class WorkerPool:
    """Who fits.

    Attributes:
        executor: where parts are sent.
        count: parts that run at the same time; twice as many are in flight.
        frames_per_part: None: whole files only.
        send_content: the workers cannot read the files by their paths.
    """

    executor: Executor
    count: int
    frames_per_part: int | None = None
    send_content: bool = False


class _Here(Executor):
    """Runs everything at once in the calling thread."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """A future that is done."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@contextmanager
def in_this_process() -> Iterator[WorkerPool]:
    """No other process: the cheapest for a few frames."""
    yield WorkerPool(_Here(), 1, frames_per_part=1)


@contextmanager
def processes(count: int, frames_per_part: int = 4) -> Iterator[WorkerPool]:
    """So many processes, warm from the compiled kernels' cache, one thread each; they end with the context.

    An exception, Ctrl-C for one, ends them at once.
    """
    pool = _Processes(count)
    try:
        yield WorkerPool(pool, count, frames_per_part)
    except BaseException:
        pool.terminate()
        raise
    pool.shutdown(cancel_futures=True)


class _Processes(Executor):
    """Like ProcessPoolExecutor, but continues with new processes after one has died."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._pool, self._children = _start(count)

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """See Executor."""
        try:
            return self._pool.submit(fn, *args, **kwargs)
        except BrokenProcessPool:
            self._pool.shutdown(wait=False)
            self._pool, self._children = _start(self._count)
            return self._pool.submit(fn, *args, **kwargs)

    def terminate(self) -> None:
        """End the processes at once, whatever they do."""
        self._pool.shutdown(wait=False, cancel_futures=True)
        for child in self._children:
            child.terminate()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """See Executor."""
        self._pool.shutdown(wait=wait, cancel_futures=cancel_futures)


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _start(count: int) -> tuple[ProcessPoolExecutor, list[BaseProcess]]:
    """A pool and its processes, which are starting."""
    # Fresh interpreters: a fork would inherit locks that threads of this process hold.
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), initializer=_begin)
    before = multiprocessing.active_children()
    with _for_children():
        pool.submit(os.getpid)  # the first submission starts all processes
    return pool, [child for child in multiprocessing.active_children() if child not in before]


@contextmanager
def _for_children() -> Iterator[None]:
    """What children inherit when they start: one thread per library, and no Ctrl-C, which is the parent's to answer."""
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _begin() -> None:
    """Start of a worker: end with the parent, even if that was killed; then load the compiled kernels."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    from platform_daemon.estimation.compilation import warm_up

    warm_up()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
