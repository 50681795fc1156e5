"""A short run of the kills in the write path; `make write-kills` is the long one."""

import pytest

from tests.campaigns.write_kills import at_random


@pytest.mark.long
def test_kills_at_random_moments_lose_double_and_leave_nothing(tmp_path):
    found = at_random(tmp_path, 12, seed=7)
    assert found.kills == 12
    assert found.acknowledged > 0
    assert found.clean, found
