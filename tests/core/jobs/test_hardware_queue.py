"""What waits, in which order, and what of it will begin by itself."""

from types import SimpleNamespace

import pytest

from drivers.errors import DeviceStateError
from platform_daemon.core.jobs.hardware_queue import Ended, HardwareQueue
from platform_daemon.core.jobs.jobs import Job
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.service.queue_edits import edit_waiting, put_in_order
from platform_daemon.core.state.errors import StorageError
from platform_daemon.features.self_test.schema import SelfTestRequest

OTHER = SimpleNamespace(request=SelfTestRequest(priority=2), total=7, unit="shots", no_result=None)


@pytest.fixture
def queue():
    return HardwareQueue()


def asked(queue, name, priority=0, kind="acquisition", arrival=None):
    job = Job(kind, SelfTestRequest(priority=priority), None, 1, "shots", identifier=name, arrival=arrival)
    queue.put(job, lambda job: None)
    return job


def names(queue):
    return "".join(job.identifier for job in queue.jobs())


def ordered(queue, order=(), keep=lambda job: None, **priorities):
    put_in_order(SimpleNamespace(queue=queue, keep=keep), order, priorities)
    return names(queue)


def taken(queue, *, procedures=False):
    found = queue.take(0.0, procedures=procedures)
    return None if found is None else found.job.identifier


def test_a_job_that_was_paused_before_it_began_holds_nobody_up(queue):
    assert not queue.awaits
    job = asked(queue, "a")
    assert queue.awaits
    job.pause_requested.set()
    assert not queue.awaits
    assert queue.take(0.0) is None
    job.cancel_requested.set()  # it is taken, so that it ends
    assert queue.awaits


def test_the_highest_priority_begins_first_and_equal_ones_as_they_were_asked_for(queue):
    for name, priority in (("a", 0), ("b", -5), ("c", 10), ("d", 0), ("e", 10)):
        asked(queue, name, priority)
    assert names(queue) == "ceadb"


def test_what_is_put_in_order_by_hand_stays_there_whatever_priority_comes_later(queue):
    for name, priority in (("a", 0), ("b", 5), ("c", 0)):
        asked(queue, name, priority)
    assert ordered(queue, ["c"]) == "cba"
    asked(queue, "d", 100)
    assert names(queue) == "cdba"
    assert ordered(queue, ["a"]) == "acdb"


def test_a_new_priority_moves_a_job_also_out_of_an_order_given_before(queue):
    for name in "abc":
        asked(queue, name)
    assert ordered(queue, ["c", "b"]) == "cba"
    assert ordered(queue, c=-1) == "bac"
    assert ordered(queue, ["c"], c=7, a=1) == "cba"
    assert [job.priority for job in queue.jobs()] == [7, 0, 1]


def test_an_order_and_a_priority_can_be_undone(queue):
    for k, name in enumerate("abc"):
        asked(queue, name, arrival=k)
    assert ordered(queue, ["c", "a"]) == "cab"
    assert ordered(queue, a=0, c=0) == "abc"
    assert ordered(queue, b=9) == "bac"
    assert ordered(queue, b=0) == "abc"


def test_only_what_changed_is_kept_and_nothing_has_where_the_disk_does_not_take_it(queue):
    jobs, kept = [asked(queue, name, arrival=k) for k, name in enumerate("abcd")], []
    assert ordered(queue, ["c"], keep=kept.append) == "cabd"
    assert kept == [jobs[2]]
    assert ordered(queue, ["c"], keep=kept.append) == "cabd"
    assert len(kept) == 1

    def full(job):
        if job is jobs[3]:
            raise StorageError("the disk is full")

    with pytest.raises(StorageError):
        ordered(queue, ["d", "b"], keep=full, a=7)
    assert names(queue) == "cabd"
    assert [(job.place, job.priority) for job in jobs] == [(None, 0), (None, 0), (0, 0), (None, 0)]


def test_what_an_ended_job_had_in_the_queue_is_not_that_of_the_one_that_goes_on_with_it():
    work = SimpleNamespace(kind="acquisition", request=SelfTestRequest(), total=1, unit="shots", no_result=None)
    before = Job("acquisition", SelfTestRequest(), None, 1, "shots", place=3, arrival=8)
    again = Job.of(work, again=before)
    assert (again.place, again.arrival) == (3, 8)
    before.end(JobState.CANCELLED)
    again = Job.of(work, again=before)
    assert (again.place, again.arrival) == (None, None)


def test_a_procedure_begins_when_the_hardware_is_free_and_nothing_comes_before_its_first_step(queue):
    asked(queue, "a")
    assert taken(queue, procedures=True) is None
    assert taken(queue) == "a"
    procedure = asked(queue, "p", kind="procedure")
    asked(queue, "q", kind="procedure")
    asked(queue, "b")
    assert taken(queue, procedures=True) is None  # a has the hardware
    assert taken(queue) is None  # it has ended, and the procedure is the next
    assert taken(queue, procedures=True) == "p"
    assert queue.awaits
    assert taken(queue) is None  # its first step has not been asked for
    asked(queue, "1").within = procedure.identifier
    assert taken(queue) == "1"
    asked(queue, "2").within = procedure.identifier
    assert taken(queue) == "b"  # between its steps the others
    assert taken(queue) == "2"
    assert not queue.awaits  # one procedure at a time
    assert taken(queue) is None
    assert taken(queue, procedures=True) == "q"


def test_a_procedure_that_rests_before_its_first_step_lets_others_go_first(queue):
    procedure = asked(queue, "p", kind="procedure")
    asked(queue, "a")
    assert taken(queue, procedures=True) == "p"
    procedure.pause_requested.set()
    assert taken(queue) == "a"


def test_a_change_that_the_disk_does_not_take_changes_nothing(queue):
    job = asked(queue, "a", 5)
    before = job.request

    def keep(job):
        raise StorageError("the disk is full")

    with pytest.raises(StorageError):
        edit_waiting(SimpleNamespace(queue=queue, keep=keep), job, lambda: OTHER)
    assert (job.request, job.total) == (before, 1)
    kept = []
    edit_waiting(SimpleNamespace(queue=queue, keep=kept.append), job, lambda: OTHER)
    assert kept == [job]
    assert (job.request, job.total, job.priority) == (OTHER.request, 7, 2)
    assert queue.take(0.0).work is OTHER
    job.begin()
    with pytest.raises(DeviceStateError, match="has not begun"):
        edit_waiting(SimpleNamespace(queue=queue, keep=kept.append), job, lambda: OTHER)


def test_nothing_begins_after_the_end(queue):
    asked(queue, "a")
    queue.put_end()
    with pytest.raises(Ended):
        queue.take(0.0)
