"""A job as other processes see it: nothing of it is lost or changed on the way."""

import json
import math

import pytest

from drivers.errors import DeviceFault, InputError, SequenceRejected
from platform_daemon.core.jobs.jobs import Job
from platform_daemon.core.schemas.acquisitions import AcquisitionResult
from platform_daemon.core.schemas.base import EXAMPLES, NoResult, to_json
from platform_daemon.core.schemas.fits import FitReport
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.schemas.rpc import RpcAnswer
from platform_daemon.core.service.job_view import JobView
from platform_daemon.features.fit.request_schema import RecordingFitRequest


def read(view):
    """What the other side of the socket reads."""
    line = to_json(RpcAnswer(value=view.to_wire(), error=None), allow_nan=True)
    return RpcAnswer.model_validate_json(line).value


def sent(view):
    """The same view on the other side of the socket."""
    return JobView.from_wire(read(view))


def a_series():
    return Job("acquisition", AcquisitionRequest(resonator="jewel", priority=3), AcquisitionResult(), 3, "shots")


def test_one_that_waits_and_is_paused_is_the_same_on_both_sides():
    job = a_series()
    job.ask_pause(pause=True)
    view = JobView.of(job)
    assert (view.kind, view.identifier, view.state) == ("acquisition", job.identifier, JobState.QUEUED)
    assert (view.request, view.result, view.paused) == (job.request, job.result, True)
    assert sent(view) == view


def test_one_that_asks_for_something_says_what():
    job = a_series()
    job.begin()
    job.ask("turn the resonator")
    view = sent(JobView.of(job))
    assert (view.question, view.state, view.paused) == ("turn the resonator", JobState.RUNNING, False)
    job.answered()
    assert sent(JobView.of(job)).question is None


def test_one_that_has_ended_is_not_paused_whatever_was_asked_before():
    job = a_series()
    job.begin()
    job.ask_pause(pause=True)
    job.end(JobState.CANCELLED)
    assert not JobView.of(job).paused


@pytest.mark.parametrize("error", [DeviceFault("it burns", where="x", remedy="run"), SequenceRejected("too long")])
def test_why_one_has_failed_comes_with_its_class_and_its_words(error):
    job = a_series()
    job.begin()
    job.end(JobState.FAILED, error)
    found = sent(JobView.of(job)).error
    assert type(found) is type(error)
    assert (str(found), found.title, found.remedy) == (str(error), error.title, error.remedy)


def test_an_error_that_nobody_foresaw_is_told_too():
    job = a_series()
    job.begin()
    job.end(JobState.FAILED, ZeroDivisionError("by zero"))
    assert "ZeroDivisionError" in str(sent(JobView.of(job)).error)


def test_numbers_that_json_does_not_have_cross_the_socket():
    table = json.loads((EXAMPLES / "fit_report.json").read_text())
    frame = next(each for each in table["frames"] if each["parameters"])
    next(iter(frame["parameters"].values()))["std"] = math.nan
    job = Job("fit", RecordingFitRequest(recording="a"), NoResult(), 1, "frames")
    job.result = FitReport.model_validate(table)
    found = sent(JobView.of(job)).result
    assert to_json(found, allow_nan=True) == to_json(job.result, allow_nan=True)
    assert "NaN" in to_json(found, allow_nan=True)


@pytest.mark.parametrize("kind", ["walk", "fit", "self_test"])
def test_a_record_is_read_as_one_of_its_kind_only(kind):
    message = read(JobView.of(a_series()))
    with pytest.raises((InputError, ValueError), match=rf"no job is of the kind '{kind}'|[Rr]ecord"):
        JobView.from_wire({**message, "record": {**message["record"], "kind": kind}})
