"""Jobs that waited when the daemon ended, while a fault keeps them from being queued again."""

import pytest

from drivers.errors import InterlockError
from platform_daemon.engine import JobRecords, job_records
from platform_daemon.engine.jobs import Job
from platform_daemon.link.queue import take_up_queue
from platform_daemon.schemas import AcquisitionRequest, AcquisitionResult, JobState
from platform_daemon.store import StorageError
from platform_daemon.store.data_folder import open_data_folder
from tests.kit.acquisitions import SHORT_JEWEL


class Fault:
    """Nothing may be queued."""

    def take_up(self, job, stops):
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
    take_up_queue(made.engine, Fault())
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
    take_up_queue(made.engine, made.owned)
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

    def take_up(self, job, stops):
        self.owned.take_up(job, stops)
        while self.happens:
            self.happens.pop()()


def test_a_stop_while_they_are_queued_again_holds_for_all_of_them(left):
    made, jobs, records = left
    take_up_queue(made.engine, Meanwhile(made.owned, made.owned.outputs_off))
    for job in jobs:
        made.engine.job("acquisition", job.identifier).ended.wait(20)
    assert states(jobs, records) == [JobState.CANCELLED] * 2


def test_those_that_a_daemon_which_ends_has_not_queued_again_wait_for_the_next_one(left):
    made, jobs, records = left
    take_up_queue(made.engine, Meanwhile(made.owned, lambda: made.engine.close(keep_queue=True)))
    assert records.one(jobs[1].identifier).state is JobState.QUEUED


def test_a_resumed_series_that_waits_is_queued_again(tmp_path, linked_in):
    jobs = open_data_folder(tmp_path).jobs
    request = AcquisitionRequest.model_validate(SHORT_JEWEL)
    job = Job("acquisition", request, AcquisitionResult(), 3, "shots")
    job.result = AcquisitionResult(recording=f"{job.identifier}.h5")
    JobRecords(jobs).save(job)
    made = linked_in(tmp_path)
    take_up_queue(made.engine, made.owned)
    again = made.engine.job("acquisition", job.identifier)
    made.engine.outputs_off()
    again.ended.wait(20)
    made.remote.close()
    made.server.close()
    made.engine.close()
    assert again.state is not JobState.FAILED, again.error


def test_one_that_is_being_planned_when_everything_is_stopped_is_cancelled(left, monkeypatch):
    made, jobs, records = left
    plan = made.engine.plan

    def stopped_meanwhile(request):
        found = plan(request)
        made.remote.outputs_off()
        return found

    monkeypatch.setattr(made.engine, "plan", stopped_meanwhile)
    asked = made.owned.acquire(jobs[0].request)
    assert asked.state is JobState.CANCELLED
    assert records.one(asked.identifier).state is JobState.CANCELLED
    take_up_queue(made.engine, made.owned)
    assert states(jobs, records) == [JobState.CANCELLED] * 2
    assert made.engine.status().running is None


def test_what_breaks_while_one_is_queued_again_costs_the_others_nothing(left):
    made, jobs, records = left

    class Breaks:
        def take_up(self, job, stops):
            if job.identifier == jobs[0].identifier:
                raise RuntimeError("nobody thought of it")
            made.owned.take_up(job, stops)

    take_up_queue(made.engine, Breaks())
    assert records.one(jobs[0].identifier).state is JobState.FAILED
    made.engine.job("acquisition", jobs[1].identifier).ended.wait(60)
    assert records.one(jobs[1].identifier).state is JobState.DONE


def test_why_they_are_forgotten_is_asked_before_each_of_them(left):
    made, jobs, records = left
    why = iter([None, "everything was stopped"])
    take_up_queue(made.engine, made.owned, lambda: next(why))
    forgotten = records.one(jobs[1].identifier)
    assert (forgotten.state, forgotten.warnings) == (JobState.CANCELLED, ["everything was stopped"])
    made.engine.job("acquisition", jobs[0].identifier).ended.wait(60)
    assert records.one(jobs[0].identifier).state is JobState.DONE


def test_what_a_full_disk_does_not_take_as_cancelled_does_not_begin_after_a_restart(left, monkeypatch):
    made, jobs, records = left

    def full(path, content):
        raise StorageError("the disk is full")

    with monkeypatch.context() as disk:
        disk.setattr(job_records, "write_file", full)
        assert "2 of them could not be written as cancelled" in made.remote.outputs_off().status
        assert not any(records.has(job.identifier) for job in jobs)
        assert made.remote.job("acquisition", jobs[0].identifier).state is JobState.CANCELLED
    asked = made.owned.acquire(jobs[0].request)  # the disk takes something again, and with it the rest
    assert states(jobs, records) == [JobState.CANCELLED] * 2
    made.remote.cancel("acquisition", asked.identifier)


def test_a_disk_that_refuses_at_the_start_makes_none_fail(left, monkeypatch):
    made, jobs, records = left

    def full(path, content):
        raise StorageError("the disk is full")

    with monkeypatch.context() as disk:
        disk.setattr(job_records, "write_file", full)
        take_up_queue(made.engine, made.owned)
    assert states(jobs, records) == [JobState.QUEUED] * 2
    assert [job.identifier for job in made.engine.left_waiting()] == [job.identifier for job in jobs]


def test_jobs_of_an_earlier_run_come_before_new_ones_and_one_that_goes_on_comes_last(tmp_path, linked_in):
    records = JobRecords(open_data_folder(tmp_path).jobs)
    request = AcquisitionRequest.model_validate({**SHORT_JEWEL, "shots": 50})
    jobs = [Job("acquisition", request, AcquisitionResult(), 50, "shots", arrival=k) for k in (7, 5)]
    over = Job("acquisition", request, AcquisitionResult(), 50, "shots", arrival=1)
    over.end(JobState.CANCELLED)
    for job in (*jobs, over):
        records.save(job)
    made = linked_in(tmp_path)
    first = made.owned.acquire(request).identifier
    again = made.owned.resume("acquisition", over.identifier).identifier
    take_up_queue(made.engine, made.owned)
    waiting = [each.identifier for each in made.engine.queue.jobs() if each.identifier != first]
    arrived = [records.one(each).arrival for each in waiting]
    made.engine.outputs_off()
    made.remote.close()
    made.server.close()
    made.engine.close()
    assert waiting == [jobs[1].identifier, jobs[0].identifier, again]
    assert arrived == [5, 7, 9]
