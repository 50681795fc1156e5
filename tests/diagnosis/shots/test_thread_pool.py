"""Tasks beside each other, and those that end because they are of no use any more."""

from concurrent.futures import ThreadPoolExecutor
from threading import Event

import pytest

from platform_daemon.diagnosis.shots.thread_pool import StoppableExecutor, StoppedError, beside_each_other


def test_a_search_that_is_stopped_ends_with_its_next_task_and_the_pool_goes_on():
    began, may_go_on = Event(), Event()

    def search(pool):
        for _ in range(1000):
            pool.submit(began.set).result()
            assert may_go_on.wait(10.0)
        return "found"

    with ThreadPoolExecutor(1) as pool, ThreadPoolExecutor(1) as thread:
        beside = StoppableExecutor(pool)
        running = thread.submit(search, beside)
        assert began.wait(10.0)
        beside.stop()
        may_go_on.set()
        with pytest.raises(StoppedError):
            running.result(10.0)
        assert list(pool.map(abs, [-1, 2])) == [1, 2]


def test_as_many_tasks_run_at_once_as_wait_for_each_other():
    there = [Event() for _ in range(5)]

    def meets_the_others(one):
        one.set()
        return all(other.wait(10.0) for other in there)

    assert beside_each_other(meets_the_others, there, at_once=5) == [True] * 5
