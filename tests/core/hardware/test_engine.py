"""Whatever is submitted is a job behind the interlock, one at a time; analyses run beside it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent import futures
from concurrent.futures import ThreadPoolExecutor

import pytest

from drivers.errors import DeviceFault, InterlockError, OutputsUnconfirmed
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.jobs import AnyJob, Cancelled, Job
from platform_daemon.core.jobs.submit_options import ShuttingDown
from platform_daemon.core.schemas.jobs import JobState
from tests.kit.walks import TIMEOUT_S, Walk, ended


@pytest.fixture
def engine(engine_with: Callable[..., Engine]) -> Engine:
    return engine_with()


def until_cancelled(job: AnyJob) -> None:
    assert job.cancel_requested.wait(TIMEOUT_S)
    raise Cancelled


def test_work_is_a_job_with_its_request_its_progress_and_its_result(engine: Engine) -> None:
    def do(job: AnyJob) -> None:
        job.at(2, "second step")
        job.result = "there"

    job = ended(engine.submit(Walk(do)))
    assert (job.state, job.result, job.request) == (JobState.DONE, "there", "to the corner")
    assert (job.progress().done, job.progress().total, job.progress().unit) == (2, 3, "steps")
    assert engine.job("walk", job.identifier) is job


@pytest.mark.parametrize("error", [None, DeviceFault("stumbled"), RuntimeError("fell")])
def test_however_work_ends_outputs_are_off(engine: Engine, error: Exception | None) -> None:
    def do(job: AnyJob) -> None:
        engine.platform.switch.to_transmit()
        engine.platform.amplifier.enable()
        engine.platform.amplifier.unmute()
        assert engine.platform.amplifier.status().can_put_out_power
        if error is not None:
            raise error

    job = ended(engine.submit(Walk(do)))
    assert job.state is (JobState.DONE if error is None else JobState.FAILED)
    assert not engine.platform.amplifier.status().can_put_out_power


def test_no_work_begins_on_a_platform_that_cannot_be_switched_off(
    engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    def unconfirmed() -> None:
        raise OutputsUnconfirmed("the amplifier does not answer")

    work = Walk()
    with monkeypatch.context() as patch:
        patch.setattr(engine.platform, "outputs_off", unconfirmed)
        job = ended(engine.submit(work))
        assert isinstance(job.error, InterlockError)
        assert "does not answer" in str(engine.status().interlock)
    assert not work.begun.is_set()
    assert ended(engine.submit(work)).state is JobState.DONE
    assert engine.status().interlock is None


def test_stop_ends_the_work_that_runs_and_lets_none_begin_that_waits(engine: Engine) -> None:
    runs, waits = Walk(until_cancelled), Walk()
    jobs = engine.submit(runs), engine.submit(waits)
    assert runs.begun.wait(TIMEOUT_S)
    status = engine.status()
    assert (status.running, status.queued) == (jobs[0].identifier, (jobs[1].identifier,))
    engine.outputs_off()
    assert [ended(job).state for job in jobs] == [JobState.CANCELLED] * 2
    assert not waits.begun.is_set()


def test_a_job_that_is_to_be_cancelled_never_begins():
    """The one before it ends while outputs go off: nothing may move between that and its own cancellation."""
    work = Walk()
    job = Job.of(work)
    job.cancel_requested.set()
    job.run(work)
    assert job.state is JobState.CANCELLED
    assert not work.begun.is_set()


def test_an_engine_that_is_closed_takes_no_work(engine: Engine) -> None:
    engine.close()
    with pytest.raises(ShuttingDown, match="shutting down"):
        engine.submit(Walk())


def test_work_that_is_taken_while_the_engine_closes_ends_and_moves_nothing(
    engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    saves, saved = threading.Event(), threading.Event()

    def slowly(records: JobRecords, job: AnyJob) -> None:
        saves.set()
        saved.wait(TIMEOUT_S)

    monkeypatch.setattr(JobRecords, "save", slowly)
    work = Walk()
    with ThreadPoolExecutor(2) as callers:
        taking = callers.submit(engine.submit, work)
        assert saves.wait(TIMEOUT_S)
        closing = callers.submit(engine.close)
        futures.wait([closing], timeout=1.0)
        saved.set()
        closing.result(TIMEOUT_S)
        ended(taking.result(TIMEOUT_S))
    assert not work.begun.is_set()
