"""The self-test as a job of its own, for whoever wants to know that the chain is as it should be."""

from __future__ import annotations

from collections.abc import Callable

import structlog

from platform_daemon.schemas import NoResult, SelfTestReport, SelfTestRequest

from ..jobs import Job
from .self_test import SelfTest

log = structlog.get_logger()
SelfTestJob = Job[SelfTestRequest, SelfTestReport | NoResult]


class SelfTestWork:
    """made: the self-test of the platform as it is when the job begins, which is made even where it is switched off
    before series; raises SequenceRejected, now already, if it would leave the limits."""

    kind, unit, total, no_result = "self_test", "shots", 1.0, NoResult()

    def __init__(self, request: SelfTestRequest, made: Callable[[], SelfTest]) -> None:
        self.request, self._made = request, made
        made()

    def __call__(self, job: SelfTestJob) -> None:
        """Raises SelfTestFailed that says what is wrong, Cancelled, DeviceError."""
        job.at(0, "self-test")
        found = self._made()(job.cancel_requested.is_set)
        assert found is not None
        job.result = found
        log.info("self_test_passed", **found.model_dump())
        job.at(1, "done")
