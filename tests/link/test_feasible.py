"""What a dry run tells beside the plan."""

import pytest

from drivers.errors import InterlockError
from platform_daemon.schemas import AcquisitionRequest
from platform_daemon.settings import load_platform
from platform_daemon.supervisor import guard_for
from tests.kit.acquisitions import SHORT_JEWEL

REQUEST = AcquisitionRequest.model_validate(SHORT_JEWEL)


def test_a_lease_beyond_the_limit_is_told_by_a_dry_run_and_by_the_request(linked, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    section = load_platform("lab", ["guard.lease_s=12.0"]).section
    guard = guard_for(section, max_lease_s=8.0)
    monkeypatch.setattr(linked.engine.platform, "guard", guard)
    try:
        for ask in (linked.remote.dry_run, linked.remote.acquire):
            with pytest.raises(InterlockError, match="the lease of the guard is 12 s") as refused:
                ask(REQUEST)
            assert "limits.max_lease_s is 8 s" in str(refused.value)
            assert refused.value.remedy
        assert linked.remote.status().running is None
    finally:
        guard.close()
