"""The start of the hardware process, while devices do not open and while the queue is taken up."""

import threading
import time
from types import SimpleNamespace

import pytest

from drivers.errors import DeviceLost
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.jobs import Job
from platform_daemon.core.jobs.workers.limits import WorkerLimits
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.schemas.acquisitions import AcquisitionResult
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.service.server import LinkServer
from platform_daemon.core.service.stopping import StoppedMeanwhile, Stopper, stop_mark
from platform_daemon.core.settings import load_platform
from platform_daemon.features.acquire import series_plan
from platform_daemon.features.schedules.schedules import Schedules
from platform_daemon.processes.assembly import start_engine
from platform_daemon.processes.hardware_process import EngineOpener
from tests.kit.acquisitions import SHORT_JEWEL


class Start:
    """With two jobs from before; `lost`: its devices do not open; `after`: is called with its engine."""

    def __init__(self, folder, *, forget=False):
        self.data = open_data_folder(folder)
        self.records, self.mark, self.lost, self.after = JobRecords(self.data.state), stop_mark(folder), False, []
        self.jobs = [
            Job("acquisition", AcquisitionRequest.model_validate(SHORT_JEWEL), AcquisitionResult(), 3, "shots")
            for _ in range(2)
        ]
        for job in self.jobs:
            self.records.save(job)
        self.opener = EngineOpener(self.engine, self.data, self.mark, WorkerLimits(), forget=forget)
        launcher = SimpleNamespace(outcome=None)
        self.opener.schedules = Schedules(self.data.schedules, launcher)

    def engine(self):
        if self.lost:
            raise DeviceLost("it is not plugged in")
        made = start_engine(load_platform("simulated"), self.records)
        for each in self.after:
            each(made)
        return made

    def states(self):
        return [self.records.one(job.identifier).state for job in self.jobs]

    def close(self):
        self.opener.close()
        self.opener.schedules.close()


@pytest.fixture
def start(tmp_path):
    made = Start(tmp_path)
    yield made
    made.close()


def test_a_stop_while_devices_do_not_open_cancels_what_waits_once_they_do(start, monkeypatch):
    monkeypatch.setattr("platform_daemon.processes.hardware_process._RETRY_S", 0.0)
    start.lost = True
    start.opener.open()
    with pytest.raises(DeviceLost):
        start.opener.hardware()
    start.opener.stop_requested()
    assert start.mark.is_set  # should this process die before they open
    start.lost = False
    start.opener.hardware()
    assert start.states() == [JobState.CANCELLED] * 2
    assert not start.mark.is_set


def test_a_stop_that_came_while_nobody_listened_yet_is_heard(start):
    start.after.append(lambda engine: start.mark.set())  # after the start has looked for it
    start.opener.open()
    start.opener.server_started()
    assert start.states() == [JobState.CANCELLED] * 2
    assert not start.mark.is_set


def test_a_stop_while_the_queue_is_taken_up_reaches_all_of_it(start, tmp_path, monkeypatch):
    server = LinkServer(start.opener.service, tmp_path, start.opener.stop_requested)
    stopper, told, plan = Stopper(tmp_path), [], series_plan.plan

    def stopped_meanwhile(bench, request):
        if not told:
            told.append(stopper.outputs_off())
        return plan(bench, request)

    monkeypatch.setattr(series_plan, "plan", stopped_meanwhile)
    start.opener.open()
    server.close()
    assert told[0].status.startswith("outputs are off")
    assert start.states() == [JobState.CANCELLED] * 2


def test_the_mark_of_a_stop_stays_until_it_is_made_good(start):
    start.mark.set()
    start.lost = True
    start.opener.stop_requested()
    start.opener.open()
    start.opener.close()
    assert start.mark.is_set
    assert start.states() == [JobState.QUEUED] * 2


def test_what_is_to_be_forgotten_is_cancelled_with_the_reason(tmp_path):
    start = Start(tmp_path, forget=True)
    start.opener.open()
    start.close()
    assert start.states() == [JobState.CANCELLED] * 2
    assert "--forget-queue" in start.records.one(start.jobs[0].identifier).warnings[0]


def test_a_request_that_opens_the_devices_is_refused_if_a_stop_came_meanwhile(start):
    start.after.append(lambda engine: start.opener.stop_requested())
    with pytest.raises(StoppedMeanwhile, match="everything was stopped"):
        start.opener.hardware()
    assert start.states() == [JobState.CANCELLED] * 2
    assert start.opener.hardware() is not None


def test_two_that_stop_while_the_devices_are_opened_are_both_answered(start, tmp_path):
    server = LinkServer(start.opener.service, tmp_path, start.opener.stop_requested)
    start.after.append(lambda engine: start.opener.stop_requested())  # the second one
    assert "outputs are off" in Stopper(tmp_path).outputs_off().status
    server.close()


def test_a_stop_while_the_first_opening_fails_rests_schedules_and_is_made_good_when_devices_open(start, monkeypatch):
    monkeypatch.setattr("platform_daemon.processes.hardware_process._RETRY_S", 0.0)
    paused = []
    monkeypatch.setattr(start.opener.schedules, "pause_all", paused.append)
    start.lost = True
    start.opener.open()
    start.mark.set()  # by somebody who found nobody
    start.opener.server_started()
    assert paused == ["everything was stopped"]
    start.lost = False
    start.opener.hardware()
    assert start.states() == [JobState.CANCELLED] * 2
    assert not start.mark.is_set


def test_told_to_end_while_devices_open_the_queue_is_left_for_the_next_one(start):
    ending = []

    def told_to_end(engine):
        ending.append(threading.Thread(target=start.opener.close))
        ending[0].start()
        time.sleep(0.3)

    start.after.append(told_to_end)
    start.opener.open()
    ending[0].join(30)
    assert start.states() == [JobState.QUEUED] * 2
