"""The short form of `make trend-alarms`: what is drawn is noticed, called by its name, and nothing else."""

import pytest

from tests.campaigns.trend_alarms import CASES, half_year, look, page, row_of

BY_NAME = {case.name: case for case in CASES}


@pytest.mark.parametrize("name", ["wear", "lost_magnetisation", "side_mode", "noise_source"])
def test_a_change_is_noticed_and_called_by_its_name(name):
    seen = [look(BY_NAME[name], seed) for seed in range(10, 13)]
    assert [each.name for each in seen] == [name] * 3
    assert not any(each.false for each in seen)
    assert all(each.delay < 120 for each in seen)


def test_temperature_alone_is_no_change():
    assert CASES[1].title == "temperature only"
    assert not any(look(CASES[1], seed).false for seed in range(10, 14))


def test_the_page_says_what_was_seen():
    row = row_of(CASES[2], [look(CASES[2], 0)])
    assert "| 0 of 1 | 1 of 1 |" in row
    assert "wear 1" in row
    assert row in page([row], 1, 60.0)


def test_a_half_year_is_the_same_again():
    assert half_year(CASES[0], 5) == half_year(CASES[0], 5)
