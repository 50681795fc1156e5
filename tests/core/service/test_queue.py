"""Jobs that waited when the daemon ended, while a fault keeps them from being queued again."""

import threading
import time
from contextlib import suppress

import pytest

from drivers.errors import InterlockError
from platform_daemon.core.hardware.interlock import Interlock
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.jobs import Job
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.schemas.acquisitions import AcquisitionResult
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.service.queue import take_up_queue
from platform_daemon.core.state.database import Database
from platform_daemon.features.acquire import series_plan
from platform_daemon.features.schedules.launch_work import HardwareLauncher
from tests.kit.acquisitions import SHORT_JEWEL
from tests.kit.no_room import no_room
from tests.kit.small_disk import small_disk


def fault(job):
    """Nothing may be queued."""
    raise InterlockError("a fault stands")


@pytest.fixture
def left(tmp_path, linked_in):
    """Two jobs of an earlier run, and a daemon that may not queue them."""
    records = JobRecords(open_data_folder(tmp_path).state)
    request = AcquisitionRequest.model_validate(SHORT_JEWEL)
    jobs = [Job("acquisition", request, AcquisitionResult(), 3, "shots") for _ in range(2)]
    for job in jobs:
        records.save(job)
    made = linked_in(tmp_path)
    take_up_queue(made.engine, fault)
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
    take_up_queue(made.engine, made.owned.take_up)
    assert made.engine.status().running is None
    assert made.engine.left_waiting() == []


def test_one_that_is_cancelled_stays_so_and_the_other_waits_for_the_next_start(left):
    made, jobs, records = left
    made.remote.cancel("acquisition", jobs[0].identifier)
    made.engine.close(keep_queue=True)
    assert states(jobs, records) == [JobState.CANCELLED, JobState.QUEUED]


def meanwhile(owned, act):
    """Queues jobs again; once the first of them is queued, `act` is called."""
    happens = [act]

    def take_up(job):
        owned.take_up(job)
        while happens:
            happens.pop()()

    return take_up


def test_a_stop_while_they_are_queued_again_holds_for_all_of_them(left):
    made, jobs, records = left
    take_up_queue(made.engine, meanwhile(made.owned, made.owned.outputs_off))
    for job in jobs:
        made.engine.job("acquisition", job.identifier).ended.wait(20)
    assert states(jobs, records) == [JobState.CANCELLED] * 2


def test_those_that_a_daemon_which_ends_has_not_queued_again_wait_for_the_next_one(left):
    made, jobs, records = left
    take_up_queue(made.engine, meanwhile(made.owned, lambda: made.engine.close(keep_queue=True)))
    assert records.one(jobs[1].identifier).state is JobState.QUEUED


def test_a_resumed_series_that_waits_is_queued_again(tmp_path, linked_in):
    jobs = open_data_folder(tmp_path).state
    request = AcquisitionRequest.model_validate(SHORT_JEWEL)
    job = Job("acquisition", request, AcquisitionResult(), 3, "shots")
    job.result = AcquisitionResult(recording=f"{job.identifier}.h5")
    JobRecords(jobs).save(job)
    made = linked_in(tmp_path)
    take_up_queue(made.engine, made.owned.take_up)
    again = made.engine.job("acquisition", job.identifier)
    made.engine.outputs_off()
    again.ended.wait(20)
    made.remote.close()
    made.server.close()
    made.engine.close()
    assert again.state is not JobState.FAILED, again.error


def test_shots_that_are_gone_when_a_series_is_resumed_are_told(tmp_path, linked_in):
    request = AcquisitionRequest.model_validate({**SHORT_JEWEL, "shots": 3})
    job = Job("acquisition", request, AcquisitionResult(recording="x", shots=2), 3, "shots", done=2)
    job.end(JobState.CANCELLED)
    JobRecords(open_data_folder(tmp_path).state).save(job)
    made = linked_in(tmp_path)
    made.owned.resume("acquisition", job.identifier)
    again = made.engine.job("acquisition", job.identifier)
    again.ended.wait(60)
    made.remote.close()
    made.server.close()
    made.engine.close()
    assert (again.state, again.result.shots) == (JobState.DONE, 3), again.error
    assert any("2 of 2 shots are missing on the disk" in each for each in again.warnings)


def test_one_that_is_being_planned_when_everything_is_stopped_is_cancelled(left, monkeypatch):
    made, jobs, records = left
    plan = series_plan.plan_series

    def stopped_meanwhile(engine, request):
        found = plan(engine, request)
        made.remote.outputs_off()
        return found

    monkeypatch.setattr(series_plan, "plan_series", stopped_meanwhile)
    asked = made.owned.submit("acquisition", jobs[0].request)
    assert asked.state is JobState.CANCELLED
    assert records.one(asked.identifier).state is JobState.CANCELLED
    take_up_queue(made.engine, made.owned.take_up)
    assert states(jobs, records) == [JobState.CANCELLED] * 2
    assert made.engine.status().running is None


def test_what_breaks_while_one_is_queued_again_costs_the_others_nothing(left):
    made, jobs, records = left

    def breaks(job):
        if job.identifier == jobs[0].identifier:
            raise RuntimeError("nobody thought of it")
        made.owned.take_up(job)

    take_up_queue(made.engine, breaks)
    assert records.one(jobs[0].identifier).state is JobState.FAILED
    made.engine.job("acquisition", jobs[1].identifier).ended.wait(60)
    assert records.one(jobs[1].identifier).state is JobState.DONE


def test_why_they_are_forgotten_is_asked_before_each_of_them(left):
    made, jobs, records = left
    why = iter([None, "everything was stopped"])
    take_up_queue(made.engine, made.owned.take_up, lambda: next(why))
    forgotten = records.one(jobs[1].identifier)
    assert (forgotten.state, forgotten.warnings) == (JobState.CANCELLED, ["everything was stopped"])
    made.engine.job("acquisition", jobs[0].identifier).ended.wait(60)
    assert records.one(jobs[0].identifier).state is JobState.DONE


def test_what_a_full_disk_does_not_take_as_cancelled_does_not_begin_after_a_restart(left, monkeypatch):
    made, jobs, records = left

    with monkeypatch.context() as disk:
        disk.setattr(Database, "transaction", no_room)
        assert "of 2 it is not on the disk" in made.remote.outputs_off().status
        assert records.load() == []  # another process would not know them
        assert made.remote.job("acquisition", jobs[0].identifier).state is JobState.CANCELLED
    asked = made.owned.submit("acquisition", jobs[0].request)  # the disk takes something again, and with it the rest
    assert states(jobs, records) == [JobState.CANCELLED] * 2
    made.remote.cancel("acquisition", asked.identifier)


def test_a_disk_that_refuses_at_the_start_makes_none_fail(left, monkeypatch):
    made, jobs, records = left

    with monkeypatch.context() as disk:
        disk.setattr(Database, "transaction", no_room)
        take_up_queue(made.engine, made.owned.take_up)
    assert states(jobs, records) == [JobState.QUEUED] * 2
    assert [job.identifier for job in made.engine.left_waiting()] == [job.identifier for job in jobs]


def test_jobs_of_an_earlier_run_come_before_new_ones_and_one_that_goes_on_comes_last(tmp_path, linked_in):
    records = JobRecords(open_data_folder(tmp_path).state)
    request = AcquisitionRequest.model_validate({**SHORT_JEWEL, "shots": 50})
    jobs = [Job("acquisition", request, AcquisitionResult(), 50, "shots", arrival=k) for k in (7, 5)]
    over = Job("acquisition", request, AcquisitionResult(), 50, "shots", arrival=1)
    over.end(JobState.CANCELLED)
    for job in (*jobs, over):
        records.save(job)
    made = linked_in(tmp_path)
    first = made.owned.submit("acquisition", request).identifier
    again = made.owned.resume("acquisition", over.identifier).identifier
    take_up_queue(made.engine, made.owned.take_up)
    waiting = [each.identifier for each in made.engine.queue.jobs() if each.identifier != first]
    arrived = [records.one(each).arrival for each in waiting]
    made.engine.outputs_off()
    made.remote.close()
    made.server.close()
    made.engine.close()
    assert waiting == [jobs[1].identifier, jobs[0].identifier, again]
    assert arrived == [5, 7, 9]


def in_thread(act):
    thread = threading.Thread(target=act, daemon=True)
    thread.start()
    return thread


def test_a_stop_that_proves_outputs_off_while_one_is_planned_holds_for_it(left, monkeypatch):
    made, jobs, records = left
    plan, prove_off, confirmed, taking = series_plan.plan_series, Interlock.prove_off, threading.Event(), []

    def planned_until_it_is_confirmed(engine, request):
        confirmed.wait(20)
        return plan(engine, request)

    def taken_up_meanwhile(interlock):
        if not taking:
            taking.append(in_thread(made.owned.take_up_queue))
            time.sleep(0.2)
        prove_off(interlock)

    monkeypatch.setattr(series_plan, "plan_series", planned_until_it_is_confirmed)
    monkeypatch.setattr(Interlock, "prove_off", taken_up_meanwhile)
    made.remote.outputs_off()
    confirmed.set()
    taking[0].join(20)
    assert states(jobs, records) == [JobState.CANCELLED] * 2
    assert made.engine.queue.jobs() == ()


def test_one_that_is_cancelled_while_it_is_planned_again_stays_so(left, monkeypatch):
    made, jobs, records = left
    plan = series_plan.plan_series

    def cancelled_meanwhile(engine, request):
        made.remote.cancel("acquisition", jobs[0].identifier)
        return plan(engine, request)

    monkeypatch.setattr(series_plan, "plan_series", cancelled_meanwhile)
    made.owned.take_up_queue()
    made.engine.job("acquisition", jobs[1].identifier).ended.wait(60)
    assert states(jobs, records) == [JobState.CANCELLED, JobState.DONE]


def test_what_is_told_the_job_of_before_is_told_the_one_in_its_place(left):
    made, jobs, records = left
    before = made.engine.job("acquisition", jobs[1].identifier)
    long = AcquisitionRequest.model_validate({**SHORT_JEWEL, "shots": 100})
    made.owned.submit("acquisition", long)  # they wait for it
    made.owned.take_up_queue()
    now = made.engine.job("acquisition", jobs[1].identifier)
    assert before is not now
    assert before.ask_pause(pause=True)
    assert now.pause_requested.is_set()
    before.request_cancel()
    assert now.state is JobState.CANCELLED
    assert records.one(jobs[1].identifier).state is JobState.CANCELLED


def test_two_that_take_the_queue_up_at_once_queue_each_job_once(left, monkeypatch):
    made, jobs, _ = left
    made.owned.submit("acquisition", AcquisitionRequest.model_validate({**SHORT_JEWEL, "shots": 100}))
    plan, other = series_plan.plan_series, []

    def unlocked_meanwhile(engine, request):
        if not other:
            other.append(in_thread(made.owned.take_up_queue))
            time.sleep(0.2)
            assert made.owned.busy()
        return plan(engine, request)

    monkeypatch.setattr(series_plan, "plan_series", unlocked_meanwhile)
    made.owned.take_up_queue()
    other[0].join(20)
    queued = [each.identifier for each in made.engine.queue.jobs()]
    assert sorted(each for each in queued if each in {job.identifier for job in jobs}) == sorted(
        job.identifier for job in jobs
    )


def test_a_scheduled_job_that_a_full_disk_does_not_take_as_cancelled_is_not_made_again(left, monkeypatch):
    made, jobs, records = left

    monkeypatch.setattr(Database, "transaction", no_room)
    made.remote.cancel("acquisition", jobs[0].identifier)
    launcher = HardwareLauncher(lambda: made.owned, records, made.data.recordings)
    assert launcher.outcome(jobs[0].identifier).state == "cancelled"


def test_one_that_is_queued_again_while_a_stop_proves_outputs_off_never_begins(left, monkeypatch):
    made, jobs, records = left
    prove_off, taken = Interlock.prove_off, []

    def taken_up_meanwhile(interlock):
        if not taken:
            taken.append(1)
            made.owned.take_up_queue()
            time.sleep(0.3)
        prove_off(interlock)

    monkeypatch.setattr(Interlock, "prove_off", taken_up_meanwhile)
    made.remote.outputs_off()
    assert states(jobs, records) == [JobState.CANCELLED] * 2
    assert [made.engine.job("acquisition", job.identifier).started for job in jobs] == [None, None]


def test_a_stop_that_is_answered_while_the_daemon_ends_holds_for_the_next_one(left, monkeypatch):
    made, jobs, records = left
    made.owned.submit("acquisition", AcquisitionRequest.model_validate({**SHORT_JEWEL, "shots": 100}))
    made.owned.take_up_queue()
    answered, join = [], made.engine.platform.close

    def stopped_meanwhile():
        answered.append([made.remote.job("acquisition", job.identifier).state for job in jobs])
        answered.append(made.remote.outputs_off().status)
        join()

    monkeypatch.setattr(made.engine.platform, "close", stopped_meanwhile)
    made.engine.close(keep_queue=True)
    assert answered[0] == [JobState.QUEUED] * 2  # they wait for the next one, and say so
    assert "cancelled" in answered[1]
    assert states(jobs, records) == [JobState.CANCELLED] * 2


def test_an_end_while_they_are_planned_makes_none_of_them_fail(left, monkeypatch):
    made, jobs, records = left

    def ends_meanwhile(engine, request):
        made.engine.close(keep_queue=True)
        raise RuntimeError("who computed it was ended")

    monkeypatch.setattr(series_plan, "plan_series", ends_meanwhile)
    made.owned.take_up_queue()
    assert states(jobs, records) == [JobState.QUEUED] * 2


def test_an_end_finishes_what_a_stop_has_wished_and_waits_for_no_disk(left, monkeypatch):
    made, jobs, records = left
    made.owned.submit("acquisition", AcquisitionRequest.model_validate({**SHORT_JEWEL, "shots": 100}))
    made.owned.take_up_queue()
    first, second = (made.engine.job("acquisition", job.identifier) for job in jobs)
    first.cancel_requested.set()  # the stop was cut off there
    with second.held():  # its record is being written
        closing = in_thread(lambda: made.engine.close(keep_queue=True))
        closing.join(20)
        assert not closing.is_alive()
    assert states(jobs, records) == [JobState.CANCELLED, JobState.QUEUED]


def test_on_a_real_disk_without_room_what_a_stop_cancels_stays_so(tmp_path, linked_in):
    with small_disk(tmp_path / "disk", 4) as folder:
        records = JobRecords(open_data_folder(folder).state)
        request = AcquisitionRequest.model_validate(SHORT_JEWEL)
        jobs = [Job("acquisition", request, AcquisitionResult(), 3, "shots") for _ in range(2)]
        for job in jobs:
            records.save(job)
        made = linked_in(folder)
        with suppress(OSError), (folder / "filler").open("wb", buffering=0) as filler:
            while True:
                filler.write(bytes(4096))
        made.remote.outputs_off()  # what is emptied makes room for what comes after it
        told = [made.remote.job("acquisition", job.identifier).state for job in jobs]
        left = records.load(waiting=frozenset({"acquisition"}))
        made.remote.close()
        made.server.close()
        made.engine.close(keep_queue=True)
        assert told == [JobState.CANCELLED] * 2
        assert all(job.state is JobState.CANCELLED for job in left)
