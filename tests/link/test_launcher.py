"""Schedules on a real engine over the simulated platform."""

import json
import time

import pytest

from drivers.errors import InputError
from platform_daemon.engine import JobRecords
from platform_daemon.link import HardwareLauncher
from platform_daemon.schedules import Schedules
from platform_daemon.schemas import ScheduleRequest


def asked(resonator="jewel"):
    work = {"kind": "acquisition", "request": {"resonator": resonator, "shots": 1, "sequence": {"rx_s": 0.3}}}
    told = {"name": "night", "trigger": {"every_s": 3600.0}, "work": work}
    return ScheduleRequest.model_validate_json(json.dumps(told))


@pytest.fixture
def schedules(linked, tmp_path):
    made = Schedules(
        tmp_path / "schedules.db",
        HardwareLauncher(lambda: linked.owned, JobRecords(linked.data.jobs), linked.data.recordings),
    )
    yield made
    made.close()


def test_a_scheduled_series_is_measured_once_and_its_recording_stands_in_the_ledger(schedules, linked):
    identifier = schedules.add(asked()).identifier
    end = time.monotonic() + 120
    schedules.step()
    while (row := schedules.page(identifier).rows[0]).state in {"due", "started"} and time.monotonic() < end:
        time.sleep(0.2)
        schedules.step()
    assert (row.state, row.reason) == ("run", None)
    assert row.recording == row.job
    assert len(linked.owned.job_ids("acquisition")) == 1


def test_a_resonator_that_is_not_there_is_refused_before_it_is_kept(schedules):
    with pytest.raises(InputError, match="nobody"):
        schedules.add(asked("nobody"))
    assert schedules.list() == ()
