"""Kernels that are not there at the first try."""

import threading
from concurrent.futures import ThreadPoolExecutor

from platform_daemon.engine import warm_fits
from platform_daemon.engine.warm_fits import WarmFits
from platform_daemon.workers import OverBounds


class Slow:
    """A computer on which compiling takes longer than one work may, twice."""

    def __init__(self):
        self.tries = 0

    def compute(self, kind, task, tell, stop):
        self.tries += 1
        if self.tries < 3:
            raise OverBounds("planning took longer than 60 s")
        return 1.0

    def close(self):
        pass


def test_a_warm_up_that_takes_too_long_is_tried_again(monkeypatch):
    monkeypatch.setattr(warm_fits, "AGAIN_S", 0.01)
    computer = Slow()
    with ThreadPoolExecutor(1) as thread:
        warm = WarmFits(thread, computer)
        warm.begin()
        assert warm.done.wait(10)
    assert computer.tries == 3


def test_once_it_ends_it_is_not_tried_again(monkeypatch):
    monkeypatch.setattr(warm_fits, "AGAIN_S", 0.01)
    broken = []
    monkeypatch.setattr(threading, "excepthook", broken.append)
    thread, computer = ThreadPoolExecutor(1), Slow()
    warm = WarmFits(thread, computer)
    warm.begin()
    thread.shutdown()
    assert not warm.done.wait(0.1)
    assert computer.tries == 1
    assert broken == []
