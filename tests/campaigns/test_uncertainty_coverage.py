"""The campaign of the budgets' coverage, with few draws; `make coverage-campaign` makes a thousand."""

import math

import pytest

from tests.campaigns.uncertainty_coverage import QUANTITIES, by_fits, run


@pytest.mark.long
def test_intervals_cover_and_fail_where_something_is_not_declared():
    count = 150
    single, mean, listed = run(count)
    slack = 3.0 * math.sqrt(0.95 * 0.05 / count)
    for covered in (single, mean):
        for name in (*QUANTITIES, "direction"):
            assert covered.share(name) == pytest.approx(0.95, abs=slack), (name, covered)
    assert not any(name.startswith("temperature") for name in listed)
    silent, _, listed = run(count, "thermometer_k")
    assert silent.share("f_nat_hz") < 0.5
    assert any(name.startswith("temperature") for name in listed)


@pytest.mark.long
def test_intervals_of_fits_cover():
    covered = by_fits(40)
    for name in (*QUANTITIES, "direction"):
        assert covered.share(name) >= 0.85, (name, covered)
