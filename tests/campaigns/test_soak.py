"""A short soak; `make soak` is the long one."""

import pytest

from tests.campaigns.soak import SERIES, page, soak


@pytest.mark.long
def test_a_short_soak_loses_no_event_and_no_series(tmp_path):
    found = soak(tmp_path, SERIES, 8)
    assert (found.failed, found.out_of_order, found.missing, found.dropped) == ([], 0, 0, 0)
    assert found.indexed[0] == 0
    assert found.indexed[1] > SERIES
    assert "| shots, all with a fit | 100 in" in page(found, "")
