"""Schedules on a real engine over the simulated platform."""

import json
import time

import pytest

from drivers.errors import InputError
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.unattended import MountRequest
from platform_daemon.core.service.local import LocalPlatformService
from platform_daemon.core.service.mounted import Mounted
from platform_daemon.features.schedules.launch_work import HardwareLauncher
from platform_daemon.features.schedules.schedules import Schedules
from platform_daemon.features.schedules.schema import ScheduleRequest


def asked(resonator="jewel"):
    work = {"kind": "acquisition", "request": {"resonator": resonator, "shots": 1, "sequence": {"rx_s": 0.3}}}
    told = {"name": "night", "trigger": {"every_s": 3600.0}, "work": work}
    return ScheduleRequest.model_validate_json(json.dumps(told))


@pytest.fixture
def schedules(linked, tmp_path):
    made = Schedules(
        tmp_path / "schedules.db",
        HardwareLauncher(lambda: linked.owned, JobRecords(linked.data.state), linked.data.recordings),
    )
    made.open()
    yield made
    made.close()


def test_a_scheduled_series_is_measured_once_and_its_recording_stands_in_the_ledger(schedules, linked):
    identifier = schedules.add(asked()).id
    end = time.monotonic() + 120
    schedules.step()
    while (row := schedules.page(identifier).items[0]).state in {"due", "started"} and time.monotonic() < end:
        time.sleep(0.2)
        schedules.step()
    assert (row.state, row.reason) == ("run", None)
    assert row.recording == row.job
    assert len(linked.owned.job_ids("acquisition")) == 1


def test_a_resonator_that_is_not_there_is_refused_before_it_is_kept(schedules):
    with pytest.raises(InputError, match="nobody"):
        schedules.add(asked("nobody"))
    assert schedules.list() == ()


def test_resonators_come_in_turn_and_what_a_person_has_to_mount_is_waited_for(linked, tmp_path, monkeypatch):
    monkeypatch.setattr(linked.engine.platform.backends["simulated"], "changes_resonators", False, raising=False)
    owned = LocalPlatformService(linked.engine, linked.folders)  # of a platform that changes none by itself
    launcher = HardwareLauncher(lambda: owned, JobRecords(linked.data.state), linked.data.recordings)
    schedules = Schedules(tmp_path / "turns.db", launcher)
    schedules.open()
    request = asked().model_copy(update={"resonators": ["thread", "jewel"]})
    owned.set_mounted(MountRequest(resonator="jewel", by="a test"))
    identifier = schedules.add(request).id
    schedules.step()
    [row] = schedules.page(identifier).items
    assert (row.state, row.job) == ("due", None)
    assert "thread has to be mounted, jewel is there" in row.reason
    assert owned.mounted().by == "a test"
    assert owned.set_mounted(MountRequest(resonator="thread", by="a test")).resonator == "thread"
    end = time.monotonic() + 120
    while (row := schedules.page(identifier).items[0]).state in {"due", "started"} and time.monotonic() < end:
        schedules.step()
        time.sleep(0.2)
    assert row.state in ("run", "late")
    assert "thread" in open_recording(linked.data.recordings / f"{row.recording}.h5").provenance.title.lower()
    owned.submit("acquisition", asked().work.request)  # somebody measures the other one, so that it is there
    assert (owned.mounted().resonator, owned.mounted().by) == ("jewel", None)
    schedules.close()


def test_what_is_mounted_outlives_a_damaged_record(tmp_path):
    mounted = Mounted(tmp_path / "mounted.json", changes_itself=False)
    assert "no mounted resonator has been reported" in mounted.missing("jewel", surely=True)
    mounted.say("jewel", "me")
    assert Mounted(tmp_path / "mounted.json", changes_itself=False).missing("jewel", surely=True) is None
    (tmp_path / "mounted.json").write_text("{")
    assert "no mounted resonator has been reported" in mounted.missing("jewel", surely=True)
    assert Mounted(tmp_path / "mounted.json", changes_itself=True).missing("jewel", surely=True) is None
    assert mounted.missing("jewel", surely=False) is None  # nobody has said that another one is there
