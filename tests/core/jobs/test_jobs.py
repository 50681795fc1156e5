import json
from datetime import UTC, datetime

import pytest

from drivers.errors import DeviceFault
from platform_daemon.core.jobs import job_registry
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.jobs import Cancelled, Job
from platform_daemon.core.registry import kinds
from platform_daemon.core.schemas.acquisitions import AcquisitionResult
from platform_daemon.core.schemas.base import EXAMPLES, NoResult
from platform_daemon.core.schemas.fits import FitReport
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.state.database import DamagedDatabase, Database
from platform_daemon.core.state.state_file import STATE_SCHEMA
from platform_daemon.features.fit.request_schema import RecordingFitRequest
from tests.kit.acquisitions import acquire
from tests.kit.no_room import no_room

ASKED = AcquisitionRequest(resonator="jewel")


def a_fit():
    return Job("fit", RecordingFitRequest(recording="a"), NoResult(), 1, "frames")


class Series:
    kind, request, total, unit, no_result = "acquisition", ASKED, 3, "shots", AcquisitionResult()

    def __call__(self, job):
        pass


def raises(error):
    def work(job):
        raise error

    return work


def test_a_job_ends_in_done_failed_or_cancelled():
    jobs = [a_fit() for _ in range(3)]
    for job, work in zip(jobs, (lambda job: None, raises(DeviceFault("x")), raises(Cancelled())), strict=True):
        job.run(work)
    assert [j.state for j in jobs] == [JobState.DONE, JobState.FAILED, JobState.CANCELLED]
    assert all(j.ended.is_set() for j in jobs)


class Clock:
    now = 0.0

    def monotonic_s(self):
        return self.now

    def utc(self):
        return datetime.now(UTC)


def a_series(shots):
    job = Job("acquisition", ASKED, AcquisitionResult(), shots, "shots", clock=Clock())
    job.begin()
    return job


def test_time_left_is_that_of_the_plan_with_its_pauses_from_the_beginning():
    job = a_series(5)
    job.clock.now = 3.0  # self-test
    job.expect([0.6, *[60.6] * 4])
    assert job.progress().time_left_s == pytest.approx(243.0)
    job.clock.now += 0.7
    job.at(1.0, "wait")
    assert job.progress().time_left_s == pytest.approx(242.4, rel=0.01)
    job.clock.now += 4 * 60.6
    job.at(5.0, "fit")
    assert job.progress().time_left_s == 0.0


def test_time_left_of_a_series_that_goes_on_leaves_out_what_was_made_before():
    job = a_series(10)
    job.at(8.0, "go on")
    job.expect([10.0] * 10)
    assert job.progress().time_left_s == pytest.approx(20.0)
    job.clock.now += 20.0  # twice as slow as planned
    job.at(9.0, "wait")
    assert job.progress().time_left_s == pytest.approx(15.0)


def test_what_a_series_has_reached_does_not_fall_when_it_is_cut_off():
    job = a_series(10)
    job.at(3.9, "listen")
    job.kept(3.0)
    job.end(JobState.CANCELLED)
    assert (job.progress().done, job.progress().fraction) == (3.0, pytest.approx(0.39))


def test_a_series_that_is_gone_on_with_has_what_it_had_reached_and_no_time_left_before_its_plan_is_known():
    job = a_series(3)
    job.at(1.9, "listen")
    job.kept(1.0)
    job.end(JobState.CANCELLED)
    again = Job.of(Series(), again=job)
    again.clock = Clock()
    assert again.progress().fraction == job.progress().fraction
    again.begin()
    again.clock.now = 0.01
    again.at(0, "self-test")
    assert again.progress().time_left_s is None


def test_time_left_follows_from_the_pace_so_far():
    job = Job("acquisition", ASKED, AcquisitionResult(), 10, "shots", clock=Clock())
    assert job.progress().time_left_s is None
    job.begin()
    job.clock.now = 4.0
    job.at(2.0, "listen")
    assert job.progress().time_left_s == pytest.approx(16.0)
    assert job.progress().fraction == pytest.approx(0.2)


def test_a_cancelled_job_never_starts():
    job = a_fit()
    job.request_cancel()
    job.run(raises(AssertionError()))
    assert job.state is JobState.CANCELLED


def test_a_job_that_was_cut_off_answers_after_a_restart_as_failed_with_the_reason(tmp_path):
    job = Job("acquisition", ASKED, AcquisitionResult(), 3, "shots")
    job.begin()
    JobRecords(tmp_path / "state.sqlite").save(job)
    (back,) = JobRecords(tmp_path / "state.sqlite").load()
    assert back.identifier == job.identifier
    assert back.state is JobState.FAILED
    assert "ended while" in str(back.error)
    assert [j.state for j in JobRecords(tmp_path / "state.sqlite").load()] == [JobState.FAILED]


def test_one_that_somebody_has_paused_before_it_began_rests_after_a_restart_too(tmp_path):
    job = Job("acquisition", ASKED, AcquisitionResult(), 3, "shots")
    records = JobRecords(tmp_path / "state.sqlite")
    job.on_change = records.save
    assert job.ask_pause(pause=True)
    waits = frozenset({"acquisition"})
    (back,) = JobRecords(tmp_path / "state.sqlite").load(waits, waits)
    again = Job.of(Series(), again=back)
    assert (again.pause_requested.is_set(), again.progress().phase) == (True, "paused")
    assert job.ask_pause(pause=False)
    assert job.progress().phase == "waiting"
    (back,) = JobRecords(tmp_path / "state.sqlite").load(waits, waits)
    assert not Job.of(Series(), again=back).pause_requested.is_set()


def test_a_broken_job_record_does_not_keep_the_others_from_loading(tmp_path):
    JobRecords(tmp_path / "state.sqlite").save(a_fit())
    with Database(tmp_path / "state.sqlite", STATE_SCHEMA).transaction() as sql:
        sql.execute("INSERT INTO jobs VALUES ('a', 'queued', '{')")
        for number, broken in enumerate([{"kind": "fit"}, {"kind": "walk"}, {"kind": 3}, {}, [], None, "fit"]):
            sql.execute("INSERT INTO jobs VALUES (?, 'queued', ?)", (f"fit-{number}", json.dumps(broken)))
    assert len(JobRecords(tmp_path / "state.sqlite").load()) == 1


def test_a_finished_job_keeps_its_result_over_a_restart(engine_with, tmp_path):
    job = acquire(engine_with(jobs=tmp_path), tmp_path / "a.h5")
    again = engine_with(jobs=tmp_path).job("acquisition", job.identifier)
    assert again.state is JobState.DONE
    assert again.result == job.result
    assert again.request == job.request


def test_of_jobs_that_have_ended_only_the_last_stay_in_memory_and_all_answer(tmp_path, monkeypatch):
    monkeypatch.setattr(job_registry, "MOST_ENDED", 3)
    events = []
    registry = job_registry.JobRegistry(JobRecords(tmp_path / "state.sqlite"), frozenset({"fit"}), events.append)
    jobs = [Job("fit", RecordingFitRequest(recording=str(k)), NoResult(), 1, "frames") for k in range(10)]
    for job in jobs:
        registry.add(job)
        job.run(lambda job: None)
    assert len(registry.all()) == 3
    assert registry.ids("fit") == tuple(job.identifier for job in jobs)
    assert [registry.job("fit", job.identifier).request.recording for job in jobs] == list(map(str, range(10)))
    assert [(e.job, str(e.state)) for e in events[:3]] == [
        (jobs[0].identifier, state) for state in ("queued", "running", "done")
    ]
    again = job_registry.JobRegistry(JobRecords(tmp_path / "state.sqlite"), frozenset({"fit"}))
    assert len(again.all()) == 3
    assert set(again.ids("fit")) == {job.identifier for job in jobs}
    with pytest.raises(job_registry.UnknownId):
        again.job("diagnosis", jobs[0].identifier)
    with Database(tmp_path / "state.sqlite", STATE_SCHEMA).transaction() as sql:
        sql.execute("UPDATE jobs SET record = '{' WHERE id = ?", (jobs[0].identifier,))
    with pytest.raises(job_registry.UnknownId):
        registry.job("fit", jobs[0].identifier)


def test_of_jobs_with_many_fits_fewer_stay_in_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(job_registry, "MOST_FITS", 7)
    registry = job_registry.JobRegistry(JobRecords(tmp_path / "state.sqlite"), frozenset({"fit"}))
    text = (EXAMPLES / "fit_report.json").read_text()
    report = FitReport.model_validate_json(text)
    report = report.model_copy(update={"frames": (report.frames[0],) * 3})
    jobs = [Job("fit", RecordingFitRequest(recording="a"), NoResult(), 1, "frames") for _ in range(5)]
    for job in jobs:
        registry.add(job)
        job.run(lambda job: setattr(job, "result", report))
    assert [job.identifier for job in registry.all()] == [job.identifier for job in jobs[-2:]]
    assert registry.job("fit", jobs[0].identifier).result == report


def test_a_long_history_is_not_read_when_one_starts_but_what_had_not_ended_is(tmp_path, monkeypatch):
    monkeypatch.setattr(job_registry, "MOST_ENDED", 5)
    records, waits = JobRecords(tmp_path / "state.sqlite"), frozenset({"acquisition"})
    for second in range(40):
        made = Job("acquisition", ASKED, AcquisitionResult(), 3, "shots", identifier=f"acquisition-{second:03d}-a")
        made.created = datetime(2026, 1, 1, 0, 0, second, tzinfo=UTC)
        if second == 3:
            made.begin()
        elif second != 2:
            made.end(JobState.DONE)
        records.save(made)
    read, one = [], JobRecords.one
    monkeypatch.setattr(JobRecords, "one", lambda self, name: (read.append(name), one(self, name))[1])
    registry = job_registry.JobRegistry(records, waits)
    assert sorted(read) == [f"acquisition-{k:03d}-a" for k in (2, 3, 35, 36, 37, 38, 39)]
    assert registry.ids("acquisition") == tuple(f"acquisition-{k:03d}-a" for k in range(40))
    assert [job.identifier for job in registry.left_waiting()] == ["acquisition-002-a"]
    assert registry.job("acquisition", "acquisition-003-a").state is JobState.FAILED
    assert registry.job("acquisition", "acquisition-004-a").state is JobState.DONE


@pytest.mark.parametrize("comment", ['\n "state": "done"', "x" * 200])
def test_whether_a_job_has_ended_is_not_told_by_what_was_asked_for(tmp_path, comment):
    asked = AcquisitionRequest(resonator="jewel", comment=comment)
    job = Job("acquisition", asked, AcquisitionResult(), 3, "shots")
    JobRecords(tmp_path / "state.sqlite").save(job)
    assert [each.identifier for each in JobRecords(tmp_path / "state.sqlite").load(most=0)] == [job.identifier]


def test_a_disk_that_refuses_keeps_nobody_from_starting(tmp_path, monkeypatch):
    job = Job("acquisition", ASKED, AcquisitionResult(), 3, "shots")
    job.begin()
    JobRecords(tmp_path / "state.sqlite").save(job)

    monkeypatch.setattr(Database, "transaction", no_room)
    assert [j.state for j in JobRecords(tmp_path / "state.sqlite").load()] == [JobState.FAILED]


def test_a_procedure_between_its_steps_is_under_way_and_one_that_rests_is_not():
    registry = job_registry.JobRegistry(JobRecords(None), kinds(on_hardware=True))
    procedure = Job("procedure", None, None, 1, "shots")
    registry.add(procedure, queued=True)
    assert not registry.conducts
    procedure.begin()
    assert registry.conducts
    procedure.pause_requested.set()
    assert not registry.conducts
    procedure.pause_requested.clear()
    procedure.end(JobState.DONE)
    assert not registry.conducts


def test_a_wish_to_rest_that_comes_after_the_end_is_told_nobody_again():
    events = []
    registry = job_registry.JobRegistry(JobRecords(None), kinds(on_hardware=True), events.append)
    job = Job("acquisition", ASKED, AcquisitionResult(), 1, "shots")
    registry.add(job, queued=True)
    job.request_cancel()
    told = len(events)
    assert not job.ask_pause(pause=True)
    assert len(events) == told
    assert not job.pause_requested.is_set()


def test_a_series_that_goes_on_is_not_overwritten_by_its_end_that_the_disk_did_not_take(tmp_path, monkeypatch):
    records = JobRecords(tmp_path / "state.sqlite")
    registry = job_registry.JobRegistry(records, kinds(on_hardware=True))
    job = Job("acquisition", ASKED, AcquisitionResult(), 3, "shots")
    registry.add(job, queued=True)
    job.begin()

    with monkeypatch.context() as disk:
        disk.setattr(Database, "transaction", no_room)
        job.end(JobState.FAILED)
    again = Job("acquisition", ASKED, AcquisitionResult(), 3, "shots", identifier=job.identifier)
    registry.add(again, queued=True)
    assert records.one(job.identifier).state is JobState.QUEUED


def test_while_the_daemon_ends_what_waits_stays_and_whoever_cancels_it_is_heard(tmp_path):
    records = JobRecords(tmp_path / "state.sqlite")
    registry = job_registry.JobRegistry(records, kinds(on_hardware=True))
    waiting, running, late = (Job("acquisition", ASKED, AcquisitionResult(), 3, "shots") for _ in range(3))
    step = Job("acquisition", ASKED, AcquisitionResult(), 3, "shots", within="procedure-1")
    for job in (waiting, running, step):
        registry.add(job, queued=True)
    running.begin()
    registry.ends.set()
    registry.add(late, queued=True)  # it was being queued
    assert registry.begun() == [running, step]
    assert not waiting.begin()
    registry.cancel(registry.begun())
    running.end(JobState.CANCELLED)
    found = [records.one(job.identifier).state for job in (waiting, running, step, late)]
    assert found == [JobState.QUEUED, JobState.CANCELLED, JobState.CANCELLED, JobState.QUEUED]
    registry.cancel(registry.stoppable())  # a person stops everything
    assert records.one(waiting.identifier).state is JobState.CANCELLED


def test_one_that_cannot_be_cancelled_keeps_no_other_from_it():
    registry = job_registry.JobRegistry(JobRecords(None), kinds(on_hardware=True))
    jobs = [Job("acquisition", ASKED, AcquisitionResult(), 3, "shots") for _ in range(3)]
    for job in jobs:
        registry.add(job, queued=True)

    def breaks(job):
        raise RuntimeError("nobody thought of it")

    jobs[0].on_change = breaks
    registry.cancel(registry.stoppable())
    assert [job.state for job in jobs] == [JobState.CANCELLED] * 3


def test_an_end_is_told_once():
    events = []
    registry = job_registry.JobRegistry(JobRecords(None), kinds(on_hardware=True), events.append)
    job = Job("acquisition", ASKED, AcquisitionResult(), 1, "shots")
    registry.add(job, queued=True)
    job.request_cancel()
    told = len(events)
    registry.end_left(job, JobState.FAILED, DeviceFault("it could not be planned either"))
    assert len(events) == told
    assert job.state is JobState.CANCELLED


def test_a_record_file_with_any_damaged_page_that_a_new_record_needs_is_refused(tmp_path):
    state = tmp_path / "state.sqlite"
    JobRecords(state).save(Job("acquisition", ASKED, AcquisitionResult(), 3, "shots"))
    JobRecords(state).check()
    JobRecords(None).check()
    content = state.read_bytes()
    page = int.from_bytes(content[16:18], "big")
    for start in range(0, 4 * page, page):  # the header, the table of jobs and its two indices
        state.write_bytes(content[:start] + b"\xff" * page + content[start + page :])
        with pytest.raises(DamagedDatabase, match=r"state\.sqlite.*is damaged.*put back a copy"):
            JobRecords(state).check()
