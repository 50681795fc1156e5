"""A few deaths; `make client-kills` is the long one."""

import pytest

from tests.campaigns.client_kills import SERIES, client_kills, page


@pytest.mark.long
def test_a_script_loses_no_shot_and_makes_none_twice_beside_a_daemon_that_is_killed(tmp_path):
    found = client_kills(tmp_path, 2 * SERIES, apart=(3, 20))
    assert found.wrong == []
    assert found.shots == 2 * SERIES
    assert found.kills["all"] >= 1
    assert "| none |" in page(found, "")
