"""Work on what is stored, beside an engine."""

import threading

import pytest

from drivers.errors import InputError
from platform_daemon.core.jobs import job_registry
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.job_registry import UnknownId
from platform_daemon.core.jobs.jobs import DAEMON_ENDED, Cancelled, Job
from platform_daemon.core.jobs.submit_options import ShuttingDown
from platform_daemon.core.jobs.workers.task_executor import InProcessExecutor
from platform_daemon.core.recordings.data_folder import data_paths
from platform_daemon.core.schemas.acquisitions import AcquisitionResult
from platform_daemon.core.schemas.base import NoResult
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.service.analysis_jobs import AnalysisJobs
from platform_daemon.core.state.database import Database
from platform_daemon.core.state.state_file import STATE_SCHEMA
from platform_daemon.features.fit import work
from platform_daemon.features.fit.request_schema import RecordingFitRequest
from tests.kit.command_line import wait_for
from tests.kit.no_room import no_room
from tests.kit.walks import TIMEOUT_S, Walk


def fit_walk(request, *does):
    """The record of a job knows its kinds."""
    walk = Walk(*does)
    walk.kind, walk.request, walk.unit, walk.no_result = "fit", request, "frames", NoResult()
    return walk


def fit_of(recording):
    return RecordingFitRequest(recording=recording)


def end_of(analyses, identifier):
    """The job of that id once it has ended."""
    wait_for(lambda: analyses.job("fit", identifier).state.final, TIMEOUT_S)
    return analyses.job("fit", identifier)


@pytest.fixture
def makes(monkeypatch):
    """Has fits planned by what it is given: a function of the request."""
    return lambda make: monkeypatch.setattr(work, "plan", lambda bench, request: make(request))


@pytest.fixture
def records(tmp_path):
    return JobRecords(tmp_path / "state.sqlite")


@pytest.fixture
def analyses_of(tmp_path):
    """Makes those of a process, and closes them."""
    made = []

    def make(records):
        made.append(AnalysisJobs(InProcessExecutor(), data_paths(tmp_path), records))
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture
def analyses(analyses_of):
    return analyses_of(None)


def test_analyses_run_one_after_the_other(analyses, makes):
    goes_on, does = threading.Event(), [lambda job: goes_on.wait(TIMEOUT_S), lambda job: None]
    makes(lambda request: fit_walk(request, does.pop(0)))
    first, second = (analyses.submit("fit", fit_of(recording)) for recording in "ab")
    assert (second.state, second.request) == (JobState.QUEUED, fit_of("b"))
    goes_on.set()
    done = [end_of(analyses, job.identifier) for job in (first, second)]
    assert [job.state for job in done] == [JobState.DONE] * 2
    assert done[0].record.times.finished <= done[1].record.times.started
    assert analyses.job_ids("fit") == (first.identifier, second.identifier)
    assert analyses.jobs("fit", (second.identifier,)) == (done[1],)


def test_one_that_waits_is_cancelled_at_once_and_one_that_runs_at_its_next_safe_point(analyses, makes):
    runs = threading.Event()

    def until_cancelled(job):
        runs.set()
        job.cancel_requested.wait(TIMEOUT_S)
        raise Cancelled

    makes(lambda request: fit_walk(request, until_cancelled))
    first, second = (analyses.submit("fit", fit_of(recording)) for recording in "ab")
    assert analyses.cancel("fit", second.identifier).state is JobState.CANCELLED
    assert runs.wait(TIMEOUT_S)
    analyses.cancel("fit", first.identifier)
    assert end_of(analyses, first.identifier).state is JobState.CANCELLED


def test_jobs_in_a_state_are_found_without_reading_a_record(analyses_of, records, makes, monkeypatch):
    for name, state in (("fit-1", JobState.DONE), ("fit-2", JobState.FAILED), ("fit-3", JobState.FAILED)):
        job = Job("fit", fit_of("a"), NoResult(), 1, "frames", identifier=name)
        job.end(state)
        records.save(job)
    monkeypatch.setattr(job_registry, "MOST_ENDED", 0)  # nothing of an earlier run is kept in memory
    analyses = analyses_of(records)
    monkeypatch.setattr(records, "one", lambda name: pytest.fail(f"{name} was read"))
    assert analyses.job_ids_in("fit", (JobState.FAILED,)) == ("fit-2", "fit-3")
    assert analyses.job_ids_in("fit", (JobState.DONE, JobState.CANCELLED)) == ("fit-1",)
    goes_on = threading.Event()
    makes(lambda request: fit_walk(request, lambda job: goes_on.wait(TIMEOUT_S)))
    running = analyses.submit("fit", fit_of("b")).identifier
    assert analyses.job_ids_in("fit", (JobState.QUEUED, JobState.RUNNING)) == (running,)
    goes_on.set()


def test_closed_they_take_no_work(analyses, makes):
    makes(fit_walk)
    analyses.close()
    with pytest.raises(ShuttingDown, match="shutting down"):
        analyses.submit("fit", fit_of("a"))
    assert analyses.job_ids("fit") == ()


def test_jobs_that_need_the_platform_are_none_of_theirs(analyses_of, records):
    request = AcquisitionRequest(resonator="jewel")
    records.save(Job("acquisition", request, AcquisitionResult(), 3, "shots", identifier="acquisition-1"))
    analyses = analyses_of(records)
    analyses.take_up()
    assert analyses.job_ids("acquisition") == ()
    with pytest.raises(UnknownId):
        analyses.job("acquisition", "acquisition-1")
    with pytest.raises(InputError, match="needs the platform"):
        analyses.submit("acquisition", request)
    assert records.one("acquisition-1").state is JobState.QUEUED


def test_what_they_do_not_know_is_named(analyses):
    with pytest.raises(InputError, match="has no dry run"):
        analyses.dry_run("fit", fit_of("a"))
    with pytest.raises(InputError, match="no job is of the kind 'walk'"):
        analyses.submit("walk", None)


def test_what_cannot_be_planned_is_no_job(analyses, makes):
    def gone(request):
        raise InputError("no such recording", where="recording")

    makes(gone)
    with pytest.raises(InputError, match="no such recording"):
        analyses.submit("fit", fit_of("a"))
    assert analyses.job_ids("fit") == ()


def left_waiting(records, name, recording):
    """A job that another process has put there."""
    records.save(Job("fit", fit_of(recording), NoResult(), 1, "frames", identifier=name))


def test_what_another_process_has_put_there_and_what_was_left_is_taken_up_once(tmp_path, analyses_of, makes, records):
    made = []

    def make(request):
        if request.recording == "gone":
            raise InputError("no such recording", where="recording")
        made.append(request.recording)
        return fit_walk(request)

    makes(make)
    left_waiting(records, "fit-1", "left")
    analyses = analyses_of(JobRecords(tmp_path / "state.sqlite"))
    left_waiting(records, "fit-2", "later")
    left_waiting(records, "fit-3", "gone")
    with Database(tmp_path / "state.sqlite", STATE_SCHEMA).transaction() as sql:
        sql.execute("INSERT INTO jobs VALUES ('fit-4', 'queued', 'half')")
    for _ in range(3):
        analyses.take_up()
    assert sorted(made) == ["later", "left"]
    assert [end_of(analyses, name).state for name in ("fit-1", "fit-2")] == [JobState.DONE] * 2
    assert end_of(analyses, "fit-3").state is JobState.FAILED
    assert "no such recording" in str(analyses.job("fit", "fit-3").error)


def test_one_that_was_cancelled_while_it_waited_is_not_begun(tmp_path, analyses_of, makes, records):
    left_waiting(records, "fit-1", "a")
    analyses = analyses_of(JobRecords(tmp_path / "state.sqlite"))

    def cancelled_meanwhile(request):
        analyses.cancel("fit", "fit-1")
        return fit_walk(request)

    makes(cancelled_meanwhile)
    analyses.take_up()
    assert records.one("fit-1").state is JobState.CANCELLED


def test_what_waits_when_the_daemon_ends_waits_for_the_next_one_and_what_runs_says_why_it_ended(
    analyses_of, makes, records
):
    runs = threading.Event()

    def until_cancelled(job):
        runs.set()
        job.cancel_requested.wait(TIMEOUT_S)
        raise Cancelled

    makes(lambda request: fit_walk(request, until_cancelled))
    analyses = analyses_of(records)
    first, second = (analyses.submit("fit", fit_of(recording)) for recording in "ab")
    runs.wait(TIMEOUT_S)
    analyses.close()
    found = records.one(first.identifier)
    assert (found.state, found.warnings) == (JobState.CANCELLED, [DAEMON_ENDED])
    assert records.one(second.identifier).state is JobState.QUEUED


def test_one_that_a_full_disk_does_not_take_is_queued_once_it_does(tmp_path, monkeypatch, analyses_of, makes, records):
    makes(fit_walk)
    left_waiting(records, "fit-1", "a")
    analyses = analyses_of(JobRecords(tmp_path / "state.sqlite"))
    with monkeypatch.context() as disk:
        disk.setattr(Database, "transaction", no_room)
        analyses.take_up()
        assert analyses.job("fit", "fit-1").state is JobState.QUEUED
    analyses.take_up()
    assert end_of(analyses, "fit-1").state is JobState.DONE
