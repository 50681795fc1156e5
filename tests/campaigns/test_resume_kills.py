"""A few deaths; `make resume-kills` is the long one."""

import pytest

from tests.campaigns.resume_kills import SHOTS, page, resume_kills


@pytest.mark.long
def test_a_series_that_dies_some_times_is_as_one_that_nobody_cut_off(tmp_path):
    found = resume_kills(tmp_path, 4)
    assert found.wrong == []
    assert found.shots == found.series * SHOTS
    assert max(map(abs, found.off)) < 6.0
    assert "| deaths | 4, " in page(found, "")
