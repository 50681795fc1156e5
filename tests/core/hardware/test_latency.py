"""What Python does between two shots."""

from __future__ import annotations

import gc
import math
import sys
import threading
import time
import weakref

import pytest

from platform_daemon.core.hardware import latency
from platform_daemon.core.hardware.latency import reduce_latency


class Ring:
    """Holds itself."""

    def __init__(self):
        self.me = self


@pytest.fixture(autouse=True)
def as_before(monkeypatch):
    monkeypatch.setattr(latency, "_searched_s", -math.inf)
    before = sys.getswitchinterval()
    yield
    sys.setswitchinterval(before)
    gc.unfreeze()


def test_what_is_there_is_not_walked_over_again():
    old = [Ring() for _ in range(1000)]
    reduce_latency()
    assert gc.get_freeze_count() >= len(old)
    assert not any(isinstance(each, Ring) for each in gc.get_objects())


def test_what_a_series_left_behind_goes_before_one_a_minute_later(monkeypatch):
    ring = Ring()
    reduce_latency()
    gone, ring = weakref.ref(ring), None
    gc.collect()
    reduce_latency()
    assert gone() is not None
    monkeypatch.setattr(latency, "ALL_EVERY_S", 0.0)
    reduce_latency()
    assert gone() is None


@pytest.mark.campaign  # it measures milliseconds
def test_a_thread_that_is_needed_runs_soon_though_another_one_computes():
    def waited_s():
        """Median of 20 short sleeps, beside a thread that computes."""
        ended, waits = threading.Event(), []
        busy = threading.Thread(target=lambda: [sum(range(1000)) for _ in iter(ended.is_set, True)])
        busy.start()
        for _ in range(20):
            began = time.perf_counter()
            time.sleep(1e-4)
            waits.append(time.perf_counter() - began)
        ended.set()
        busy.join()
        return sorted(waits)[10]

    sys.setswitchinterval(0.05)
    before = waited_s()
    reduce_latency()
    assert waited_s() < 0.5 * before


def test_a_thread_that_computes_gives_way_within_half_a_millisecond():
    sys.setswitchinterval(0.05)
    reduce_latency()
    assert sys.getswitchinterval() <= 5e-4 * (1 + 1e-9)
