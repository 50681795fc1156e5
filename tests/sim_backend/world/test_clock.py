import threading
import time
from datetime import UTC, datetime, timedelta

import pytest

from drivers.clock import SystemClock
from sim_backend.options import ClockOptions
from sim_backend.world.clock import SimulatedClock

START = datetime(2026, 3, 1, 12, tzinfo=UTC)


def clock(mode):
    return SimulatedClock(ClockOptions(mode=mode, start_utc=START))


def test_fast_time_passes_only_when_somebody_sleeps():
    fast = clock("fast")
    assert fast.monotonic_s() == fast.monotonic_s() == 0.0
    begin = time.monotonic()
    fast.sleep(3600.0)
    assert time.monotonic() - begin < 1.0
    assert fast.monotonic_s() == 3600.0
    assert fast.utc() == START + timedelta(hours=1)


def test_real_time_sleeps_really():
    real = clock("realtime")
    begin = time.monotonic()
    real.sleep(0.15)
    assert time.monotonic() - begin >= 0.15
    assert 0.15 <= real.monotonic_s() < 5.0
    assert START <= real.utc() < START + timedelta(seconds=5)


def test_only_time_that_is_that_of_this_computer_is_real():
    assert SimulatedClock(ClockOptions(mode="realtime")).kind == SystemClock().kind == "real"
    for options in ({"mode": "fast"}, {"mode": "realtime", "speed": 2.0}, {"mode": "realtime", "start_utc": START}):
        assert SimulatedClock(ClockOptions(**options)).kind == "simulated"


def test_waiting_never_turns_time_back():
    fast = clock("fast")
    fast.sleep(10.0)
    assert fast.wait_until(4.0, threading.Event())
    assert fast.monotonic_s() == 10.0


@pytest.mark.parametrize("mode", ["fast", "realtime"])
def test_a_cancelled_wait_says_so_and_ends_at_once(mode):
    cancelled = threading.Event()
    cancelled.set()
    begin = time.monotonic()
    assert not clock(mode).wait_until(30.0, cancelled)
    assert time.monotonic() - begin < 1.0


def test_sleeps_of_many_threads_add_up():
    fast = clock("fast")
    threads = [threading.Thread(target=lambda: [fast.sleep(0.5) for _ in range(100)]) for _ in range(8)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert fast.monotonic_s() == pytest.approx(400.0)


def test_without_a_start_the_time_of_day_is_the_computers():
    now = SimulatedClock(ClockOptions(mode="fast")).utc()
    assert abs((datetime.now(UTC) - now).total_seconds()) < 5


def test_the_time_of_day_leaps_over_idle_time_and_is_never_before_the_computers():
    fast = SimulatedClock(ClockOptions(mode="fast"))
    time.sleep(0.2)
    called = datetime.now(UTC)
    first = fast.utc()
    assert first >= called
    assert fast.monotonic_s() == 0.0
    fast.sleep(3600.0)
    second = fast.utc()
    assert timedelta(hours=1) <= second - first < timedelta(hours=1, seconds=5)
    assert fast.utc() >= second


def test_a_given_start_keeps_the_time_of_day_apart_from_the_computers():
    fast = clock("fast")
    time.sleep(0.05)
    assert fast.utc() == START
