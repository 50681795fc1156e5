"""Work on what is stored, beside an engine."""

import threading

import pytest

from drivers.errors import InputError
from platform_daemon.engine import DAEMON_ENDED, AnalysisJobs, Job, JobRecords, ShuttingDown, job_records
from platform_daemon.engine.jobs import Cancelled
from platform_daemon.schemas import JobState, NoResult, RecordingFitRequest
from platform_daemon.workers import InThisProcess
from tests.kit.no_room import no_room
from tests.kit.walks import TIMEOUT_S, Walk, ended


def fit_walk(request, *does):
    """The record of a job knows its kinds."""
    walk = Walk(*does)
    walk.kind, walk.request, walk.unit, walk.no_result = "fit", request, "frames", NoResult()
    return walk


@pytest.fixture
def analyses():
    made = AnalysisJobs(InThisProcess())
    yield made
    made.close()


def test_analyses_run_one_after_the_other(analyses):
    goes_on = threading.Event()
    first, second = analyses.analyse(Walk(lambda job: goes_on.wait(TIMEOUT_S))), analyses.analyse(Walk())
    assert second.state is JobState.QUEUED
    goes_on.set()
    assert [ended(job).state for job in (first, second)] == [JobState.DONE] * 2


def test_closed_they_take_no_work(analyses):
    analyses.close()
    with pytest.raises(ShuttingDown, match="shutting down"):
        analyses.analyse(Walk())


def test_what_another_process_has_put_there_and_what_was_left_is_taken_up_once(tmp_path):
    made = []

    def make(request):
        if request.recording == "gone":
            raise InputError("no such recording", where="recording")
        made.append(request.recording)
        return fit_walk(request)

    def put(name, recording):
        job = Job("fit", RecordingFitRequest(recording=recording), NoResult(), 1, "frames", identifier=name)
        JobRecords(tmp_path).save(job)

    put("fit-1", "left")
    analyses = AnalysisJobs(InThisProcess(), JobRecords(tmp_path))
    try:
        put("fit-2", "later")
        put("fit-3", "gone")
        (tmp_path / "fit-4.json").write_text("half")
        for _ in range(3):
            analyses.take_up(make)
        assert sorted(made) == ["later", "left"]
        assert ended(analyses.job("fit", "fit-3")).state is JobState.FAILED
        assert "no such recording" in str(analyses.job("fit", "fit-3").error)
    finally:
        analyses.close()


def test_one_that_was_cancelled_while_it_waited_is_not_begun(tmp_path):
    job = Job("fit", RecordingFitRequest(recording="a"), NoResult(), 1, "frames", identifier="fit-1")
    JobRecords(tmp_path).save(job)
    analyses = AnalysisJobs(InThisProcess(), JobRecords(tmp_path))

    def make(request):
        analyses.job("fit", "fit-1").request_cancel()
        return fit_walk(request)

    try:
        analyses.take_up(make)
        assert JobRecords(tmp_path).one("fit-1").state is JobState.CANCELLED
    finally:
        analyses.close()


def test_what_waits_when_the_daemon_ends_waits_for_the_next_one_and_what_runs_says_why_it_ended(tmp_path):
    runs, records = threading.Event(), JobRecords(tmp_path)

    def until_cancelled(job):
        runs.set()
        job.cancel_requested.wait(TIMEOUT_S)
        raise Cancelled

    analyses = AnalysisJobs(InThisProcess(), records)
    first, second = (analyses.analyse(fit_walk(RecordingFitRequest(recording=r), until_cancelled)) for r in "ab")
    runs.wait(TIMEOUT_S)
    analyses.close()
    found = records.one(first.identifier)
    assert (found.state, found.warnings) == (JobState.CANCELLED, [DAEMON_ENDED])
    assert records.one(second.identifier).state is JobState.QUEUED


def test_one_that_a_full_disk_does_not_take_is_queued_once_it_does(tmp_path, monkeypatch):
    job = Job("fit", RecordingFitRequest(recording="a"), NoResult(), 1, "frames", identifier="fit-1")
    JobRecords(tmp_path).save(job)
    analyses = AnalysisJobs(InThisProcess(), JobRecords(tmp_path))

    try:
        with monkeypatch.context() as disk:
            disk.setattr(job_records, "write_file", no_room)
            analyses.take_up(fit_walk)
            assert analyses.job("fit", "fit-1").state is JobState.QUEUED
        analyses.take_up(fit_walk)
        assert ended(analyses.job("fit", "fit-1")).state is JobState.DONE
    finally:
        analyses.close()
