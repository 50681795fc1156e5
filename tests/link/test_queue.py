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
