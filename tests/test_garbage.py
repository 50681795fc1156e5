"""The search for garbage between shots."""

from __future__ import annotations

import gc
import weakref

import pytest

from platform_daemon.garbage import spare_what_is_there


class Ring:
    """Holds itself."""

    def __init__(self):
        self.me = self


@pytest.fixture(autouse=True)
def thawed():
    yield
    gc.unfreeze()


def test_what_is_there_is_not_walked_over_again():
    old = [Ring() for _ in range(1000)]
    spare_what_is_there()
    assert gc.get_freeze_count() >= len(old)
    assert not any(isinstance(each, Ring) for each in gc.get_objects())


def test_what_a_series_left_behind_goes_before_the_next_one():
    ring = Ring()
    spare_what_is_there()
    gone, ring = weakref.ref(ring), None
    gc.collect()
    assert gone() is not None
    spare_what_is_there()
    assert gone() is None
