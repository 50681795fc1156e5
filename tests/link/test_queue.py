"""Jobs that waited when the daemon ended, while a fault keeps them from being queued again."""

import pytest

from drivers.errors import InterlockError
from platform_daemon.engine import JobRecords
from platform_daemon.engine.jobs import Job
from platform_daemon.link.queue import take_up_queue
from platform_daemon.schemas import AcquisitionRequest, AcquisitionResult, JobState
from platform_daemon.store.data_folder import open_data_folder
from tests.kit.acquisitions import SHORT_JEWEL


class Fault:
    """Nothing may be queued."""

    def take_up(self, job):
        raise InterlockError("a fault stands")


@pytest.fixture
def left(tmp_path, linked_in):
    """Two jobs of an earlier run, and a daemon that may not queue them."""
    records = JobRecords(open_data_folder(tmp_path).jobs)
    request = AcquisitionRequest.model_validate(SHORT_JEWEL)
    jobs = [Job("acquisition", request, AcquisitionResult(), 3, "shots") for _ in range(2)]
    for job in jobs:
        records.save(job)
    made = linked_in(tmp_path)
    take_up_queue(made.engine, Fault(), forget=False)
    yield made, jobs, records
    made.remote.close()
    made.server.close()
    made.engine.close(keep_queue=True)


def states(jobs, records):
    return [records.one(job.identifier).state for job in jobs]


def test_a_stop_cancels_them_and_none_begins_when_the_fault_is_cleared(left):
    made, jobs, records = left
    made.remote.outputs_off()
    assert states(jobs, records) == [JobState.CANCELLED] * 2
    take_up_queue(made.engine, made.owned, forget=False)
    assert made.engine.status().running is None
    assert made.engine.left_waiting() == []


def test_one_that_is_cancelled_stays_so_and_the_other_waits_for_the_next_start(left):
    made, jobs, records = left
    made.remote.cancel("acquisition", jobs[0].identifier)
    made.engine.close(keep_queue=True)
    assert states(jobs, records) == [JobState.CANCELLED, JobState.QUEUED]


class Meanwhile:
    """While the first is queued again, `happens`."""

    def __init__(self, owned, happens):
        self.owned, self.happens = owned, [happens]

    def take_up(self, job):
        self.owned.take_up(job)
        while self.happens:
            self.happens.pop()()


def test_a_stop_while_they_are_queued_again_holds_for_all_of_them(left):
    made, jobs, records = left
    take_up_queue(made.engine, Meanwhile(made.owned, made.owned.outputs_off), forget=False)
    for job in jobs:
        made.engine.job("acquisition", job.identifier).ended.wait(20)
    assert states(jobs, records) == [JobState.CANCELLED] * 2


def test_those_that_a_daemon_which_ends_has_not_queued_again_wait_for_the_next_one(left):
    made, jobs, records = left
    take_up_queue(made.engine, Meanwhile(made.owned, lambda: made.engine.close(keep_queue=True)), forget=False)
    assert records.one(jobs[1].identifier).state is JobState.QUEUED


def test_a_resumed_series_that_waits_is_queued_again(tmp_path, linked_in):
    jobs = open_data_folder(tmp_path).jobs
    request = AcquisitionRequest.model_validate(SHORT_JEWEL)
    job = Job("acquisition", request, AcquisitionResult(), 3, "shots")
    job.result = AcquisitionResult(recording=f"{job.identifier}.h5")
    JobRecords(jobs).save(job)
    made = linked_in(tmp_path)
    take_up_queue(made.engine, made.owned, forget=False)
    again = made.engine.job("acquisition", job.identifier)
    made.engine.outputs_off()
    again.ended.wait(20)
    made.remote.close()
    made.server.close()
    made.engine.close()
    assert again.state is not JobState.FAILED, again.error
