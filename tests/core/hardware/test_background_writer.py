"""Shots on their way to a disk that is slow, or refuses."""

import threading
import time
from pathlib import Path

import pytest

from platform_daemon.features.acquire.background_writer import MOST_AT_ONCE, BackgroundWriter


def test_a_few_shots_wait_for_a_slow_disk_the_next_one_waits_with_the_series_and_all_are_kept_in_order():
    free, stored = threading.Event(), []

    def store(number):
        assert free.wait(10)
        stored.append(number)
        return Path(str(number))

    with BackgroundWriter() as disk:
        began = time.monotonic()
        files = [disk.put(lambda k=k: store(k)) for k in range(MOST_AT_ONCE)]
        assert time.monotonic() - began < 1.0
        assert stored == []
        threading.Timer(0.3, free.set).start()
        files.append(disk.put(lambda: store(MOST_AT_ONCE)))
        assert stored[0] == 0  # one had to be kept first
        disk.wait()
        assert stored == list(range(MOST_AT_ONCE + 1))
    assert [file.result().name for file in files] == [str(k) for k in stored]


def test_after_a_shot_that_the_disk_refused_no_later_one_is_kept():
    stored = []

    def refuse():
        raise OSError(28, "no space left")

    def put_more(disk):
        for k in range(MOST_AT_ONCE + 1):
            disk.put(lambda k=k: stored.append(k))

    with BackgroundWriter() as disk:
        first = disk.put(refuse)
        with pytest.raises(OSError, match="no space"):
            put_more(disk)
    assert first.exception() is not None
    assert stored == []


def test_what_was_put_is_kept_whatever_ends_the_series():
    stored = []

    def end_early():
        with BackgroundWriter() as disk:
            disk.put(lambda: (time.sleep(0.1), stored.append(1)))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        end_early()
    assert stored == [1]
