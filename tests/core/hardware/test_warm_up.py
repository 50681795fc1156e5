"""Kernels that are not there at the first try."""

import threading
from concurrent.futures import ThreadPoolExecutor

from platform_daemon.core.hardware import warm_up
from platform_daemon.core.hardware.warm_up import WarmUp
from platform_daemon.core.jobs.workers.bounds import OverBounds


class Slow:
    """A computer on which compiling takes longer than one work may, twice."""

    def __init__(self):
        self.tries = 0

    def run(self, kind, task, tell, stop):
        self.tries += 1
        if self.tries < 3:
            raise OverBounds("planning took longer than 60 s")
        return 1.0

    def close(self):
        pass


def nothing(tell):
    return 0.0


def test_a_warm_up_that_takes_too_long_is_tried_again(monkeypatch):
    monkeypatch.setattr(warm_up, "AGAIN_S", 0.01)
    executor = Slow()
    with ThreadPoolExecutor(1) as thread:
        warm = WarmUp(thread, executor, lambda: nothing)
        warm.begin()
        assert warm.done.wait(10)
    assert executor.tries == 3


def test_once_it_ends_it_is_not_tried_again(monkeypatch):
    monkeypatch.setattr(warm_up, "AGAIN_S", 0.01)
    broken = []
    monkeypatch.setattr(threading, "excepthook", broken.append)
    thread, executor = ThreadPoolExecutor(1), Slow()
    warm = WarmUp(thread, executor, lambda: nothing)
    warm.begin()
    thread.shutdown()
    assert not warm.done.wait(0.1)
    assert executor.tries == 1
    assert broken == []
