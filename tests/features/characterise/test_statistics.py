"""Statistics over shots."""

import math

import pytest

from platform_daemon.features.characterise.statistics import statistics_of


def test_values_that_are_not_there_do_not_count():
    found = statistics_of([1.0, None, 3.0, math.nan, 8.0])
    assert (found.shots, found.mean, found.median, found.lowest, found.highest) == (3, 4.0, 3.0, 1.0, 8.0)
    assert found.std == pytest.approx(math.sqrt(13.0))
    assert statistics_of([None]) is None
    assert statistics_of([2.0]).std is None


def test_angles_around_zero_have_a_small_scatter():
    found = statistics_of([0.1, 2 * math.pi - 0.1, 0.3, 0.1], circular=True)
    assert found.mean == pytest.approx(0.1)
    assert found.std == pytest.approx(math.sqrt(0.08 / 3))
    assert (found.lowest, found.highest) == pytest.approx((-0.1, 0.3))
    assert found.median == pytest.approx(0.1)
