"""Work on what is stored, beside an engine."""

import threading

import pytest

from platform_daemon.engine import AnalysisJobs, ShuttingDown
from platform_daemon.schemas import JobState
from platform_daemon.workers import InThisProcess
from tests.kit.walks import TIMEOUT_S, Walk, ended


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
