"""What Python does between two shots."""

from __future__ import annotations

import gc
import subprocess
import sys
import threading
import time

import pytest

from platform_daemon.__main__ import SELDOM
from platform_daemon.core.hardware.latency import reduce_latency

SEARCHES = """
import gc, weakref
from platform_daemon.core.hardware import latency
from platform_daemon.core.hardware.latency import reduce_latency

class Ring:
    def __init__(self):
        self.me = self

def rings():
    return [each for each in gc.get_objects() if isinstance(each, Ring)]

old = [Ring() for _ in range(1000)]
reduce_latency()
assert gc.get_freeze_count() >= len(old)
assert not rings()

gone = weakref.ref(old[0])
old.clear()
gc.collect()
reduce_latency()
assert gone() is not None
latency.ALL_EVERY_S = 0.0
reduce_latency()
assert gone() is None
"""


@pytest.fixture(autouse=True)
def as_before():
    before = sys.getswitchinterval()
    yield
    sys.setswitchinterval(before)


def test_what_is_there_is_not_walked_over_again_and_what_a_series_left_behind_goes_before_one_a_minute_later():
    """In a process of its own: to look through all that the tests have loaded takes 1.5 s of a processor."""
    done = subprocess.run([sys.executable, "-c", SEARCHES], capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, done.stderr


def test_each_search_is_short_though_a_command_searches_seldom():
    before = gc.get_threshold()
    gc.set_threshold(*SELDOM)
    reduce_latency()
    now, _, _ = gc.get_threshold()
    gc.set_threshold(*before)
    assert 10 * now < SELDOM[0]


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
