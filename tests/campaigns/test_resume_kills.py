"""A few deaths; `make resume-kills` is the long one."""

import pytest

from tests.campaigns.resume_kills import Plan, page, resume_kills

PLAN = Plan(kills=2, shots=40, lives_s=((1.0, 3.0),))


@pytest.mark.long
def test_a_series_that_dies_some_times_is_as_one_that_nobody_cut_off(tmp_path):
    found = resume_kills(tmp_path, PLAN)
    assert found.wrong == []
    assert found.shots == found.series * PLAN.shots
    assert max(map(abs, found.off)) < 6.0
    assert "| deaths | 2, " in page(found, "")
