"""What a dry run tells beside the plan."""

from functools import partial

import pytest

from drivers.errors import InterlockError
from platform_daemon.core.guard.guard_client import guard_for
from platform_daemon.core.jobs.workers.bounds import OverBounds
from platform_daemon.core.jobs.workers.limits import WorkerLimits
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.service.local import LocalPlatformService
from platform_daemon.core.settings import load_platform
from platform_daemon.features.acquire.series_plan import plan_series
from platform_daemon.features.sweep.schema import SweepRequest
from tests.kit.acquisitions import SHORT_JEWEL

REQUEST = AcquisitionRequest.model_validate(SHORT_JEWEL)


def test_a_lease_beyond_the_limit_is_told_by_a_dry_run_and_by_the_request(linked, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    section = load_platform("lab", ["guard.lease_s=12.0"]).section
    guard = guard_for(section, max_lease_s=8.0)
    monkeypatch.setattr(linked.engine.platform, "guard", guard)
    try:
        for ask in (linked.remote.dry_run, linked.remote.submit):
            with pytest.raises(InterlockError, match="the lease of the guard is 12 s") as refused:
                ask("acquisition", REQUEST)
            assert "limits.max_lease_s is 8 s" in str(refused.value)
            assert refused.value.remedy
        assert linked.remote.status().running is None
    finally:
        guard.close()


FIELDS_T = [1e-5 + k * 1e-8 for k in range(1000)]


@pytest.mark.parametrize("asked", ["sweep", "shot_changes"])
def test_a_plan_that_takes_longer_than_planning_may_is_refused_with_the_limit(linked, asked):
    owned = LocalPlatformService(linked.engine, linked.folders, limits=WorkerLimits().changed(["planning:0.1s"]))
    assert owned.dry_run("acquisition", REQUEST).shots == REQUEST.shots
    sweep = {"kind": "sweep", "acquisition": SHORT_JEWEL, "over": [{"key": "field_t", "values": FIELDS_T}]}
    changes = {**SHORT_JEWEL, "shot_changes": [{"field_t": field_t} for field_t in FIELDS_T]}
    ask = {
        "sweep": partial(owned.dry_run, "procedure", SweepRequest.model_validate(sweep)),
        "shot_changes": partial(owned.dry_run, "acquisition", AcquisitionRequest.model_validate(changes)),
    }[asked]
    with pytest.raises(OverBounds, match=r"the planning took longer than 0\.1 s") as over:
        ask()
    assert "--worker-limit planning:SECONDSs" in over.value.remedy


def test_a_million_shots_are_counted_without_being_listed(linked):
    many = AcquisitionRequest.model_validate({**SHORT_JEWEL, "shots": 1_000_000})
    one, all_ = (
        plan_series(linked.engine, REQUEST.model_copy(update={"shots": 1})).summary(),
        plan_series(linked.engine, many),
    )
    told = all_.summary()
    assert "shots" not in vars(all_)
    assert told.shots == 1_000_000
    assert told.disk_bytes == one.disk_bytes * 1_000_000
    assert told.duration_s == pytest.approx(one.duration_s * 1e6 + all_.sequence.pause_s * 999_999)
