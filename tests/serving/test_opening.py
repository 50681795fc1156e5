"""The start of the hardware process, while devices do not open and while the queue is taken up."""

import threading
import time
from types import SimpleNamespace

import pytest

from drivers.errors import DeviceLost
from platform_daemon.app import start_engine
from platform_daemon.engine import JobRecords
from platform_daemon.engine.jobs import Job
from platform_daemon.link import LinkServer, StoppedMeanwhile, Stopper, stop_mark
from platform_daemon.schedules import ScheduleKeeper, Schedules, rest_mark
from platform_daemon.schemas import AcquisitionRequest, AcquisitionResult, JobState
from platform_daemon.serving.hardware_process import Opening
from platform_daemon.settings import load_platform
from platform_daemon.store import open_data_folder
from platform_daemon.workers import WorkerLimits
from tests.kit.acquisitions import SHORT_JEWEL


class Start:
    """With two jobs from before; `lost`: its devices do not open; `after`: is called with its engine."""

    def __init__(self, folder, *, forget=False):
        self.data = open_data_folder(folder)
        self.records, self.mark, self.lost, self.after = JobRecords(self.data.jobs), stop_mark(folder), False, []
        self.jobs = [
            Job("acquisition", AcquisitionRequest.model_validate(SHORT_JEWEL), AcquisitionResult(), 3, "shots")
            for _ in range(2)
        ]
        for job in self.jobs:
            self.records.save(job)
        self.opening = Opening(self.engine, self.data, self.mark, WorkerLimits(), forget=forget)
        launcher = SimpleNamespace(outcome=None)
        ledger = folder / "schedules.db"
        self.opening.schedules = ScheduleKeeper(lambda: Schedules(ledger, launcher), rest_mark(ledger))

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
        self.opening.close()
        self.opening.schedules.close()


@pytest.fixture
def start(tmp_path):
    made = Start(tmp_path)
    yield made
    made.close()


def test_a_stop_while_devices_do_not_open_cancels_what_waits_once_they_do(start, monkeypatch):
    monkeypatch.setattr("platform_daemon.serving.hardware_process._AGAIN_S", 0.0)
    start.lost = True
    start.opening.open()
    with pytest.raises(DeviceLost):
        start.opening.hardware()
    start.opening.stopped()
    assert start.mark.stands  # should this process die before they open
    start.lost = False
    start.opening.hardware()
    assert start.states() == [JobState.CANCELLED] * 2
    assert not start.mark.stands


def test_a_stop_that_came_while_nobody_listened_yet_is_heard(start):
    start.after.append(lambda engine: start.mark.leave())  # after the start has looked for it
    start.opening.open()
    start.opening.listens()
    assert start.states() == [JobState.CANCELLED] * 2
    assert not start.mark.stands


def test_a_stop_while_the_queue_is_taken_up_reaches_all_of_it(start, tmp_path):
    server = LinkServer(start.opening.hardware, tmp_path, start.opening.stopped)
    stopper, told = Stopper(tmp_path), []

    def planning(engine):
        plan = engine.plan

        def stopped_meanwhile(request):
            if not told:
                told.append(stopper.outputs_off())
            return plan(request)

        engine.plan = stopped_meanwhile

    start.after.append(planning)
    start.opening.open()
    server.close()
    assert told[0].status.startswith("outputs are off")
    assert start.states() == [JobState.CANCELLED] * 2


def test_the_mark_of_a_stop_stays_until_it_is_made_good(start):
    start.mark.leave()
    start.lost = True
    start.opening.stopped()
    start.opening.open()
    start.opening.close()
    assert start.mark.stands
    assert start.states() == [JobState.QUEUED] * 2


def test_what_is_to_be_forgotten_is_cancelled_with_the_reason(tmp_path):
    start = Start(tmp_path, forget=True)
    start.opening.open()
    start.close()
    assert start.states() == [JobState.CANCELLED] * 2
    assert "--forget-queue" in start.records.one(start.jobs[0].identifier).warnings[0]


def test_a_request_that_opens_the_devices_is_refused_if_a_stop_came_meanwhile(start):
    start.after.append(lambda engine: start.opening.stopped())
    with pytest.raises(StoppedMeanwhile, match="everything was stopped"):
        start.opening.hardware()
    assert start.states() == [JobState.CANCELLED] * 2
    assert start.opening.hardware() is not None


def test_two_that_stop_while_the_devices_are_opened_are_both_answered(start, tmp_path):
    server = LinkServer(start.opening.hardware, tmp_path, start.opening.stopped)
    start.after.append(lambda engine: start.opening.stopped())  # the second one
    assert "outputs are off" in Stopper(tmp_path).outputs_off().status
    server.close()


def test_a_stop_while_the_first_opening_fails_rests_schedules_and_is_made_good_when_devices_open(start, monkeypatch):
    monkeypatch.setattr("platform_daemon.serving.hardware_process._AGAIN_S", 0.0)
    paused = []
    monkeypatch.setattr(start.opening.schedules, "pause_all", paused.append)
    start.lost = True
    start.opening.open()
    start.mark.leave()  # by somebody who found nobody
    start.opening.listens()
    assert paused == ["everything was stopped"]
    start.lost = False
    start.opening.hardware()
    assert start.states() == [JobState.CANCELLED] * 2
    assert not start.mark.stands


def test_told_to_end_while_devices_open_the_queue_is_left_for_the_next_one(start):
    ending = []

    def told_to_end(engine):
        ending.append(threading.Thread(target=start.opening.close))
        ending[0].start()
        time.sleep(0.3)

    start.after.append(told_to_end)
    start.opening.open()
    ending[0].join(30)
    assert start.states() == [JobState.QUEUED] * 2
