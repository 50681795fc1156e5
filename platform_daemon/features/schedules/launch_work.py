"""Starting the work of schedules: the owner of the hardware submits it like a request of a person."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from drivers.errors import InputError
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.jobs.jobs import DAEMON_ENDED, new_identifier
from platform_daemon.core.jobs.submit_options import SubmitOptions
from platform_daemon.core.registry import feature_of
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.service.job_view import JobView
from platform_daemon.core.service.local import LocalPlatformService
from platform_daemon.features.fit.model_check import check_model

from .analyses import ScheduledAnalyses
from .launcher import JobOutcome, Launcher
from .schema import AnyWorkRequest, DiagnosisWorkRequest, FitWorkRequest


class HardwareLauncher(Launcher):
    """See Launcher.

    hardware: returns the service of the present owner, raises DeviceError while there is none; records: of all jobs;
    recordings: their folder.
    """

    def __init__(self, hardware: Callable[[], LocalPlatformService], records: JobRecords, recordings: Path) -> None:
        self._hardware, self._records = hardware, records
        self._analyses = ScheduledAnalyses(records, recordings)

    def planned_s(self, work: AnyWorkRequest) -> float | None:
        """See Launcher; None for a self-test and for work on recordings."""
        service = self._hardware()
        if feature_of(work.kind).kind.needs_hardware:
            return service.plan(work.kind, work.request).duration_s
        if isinstance(work, FitWorkRequest):
            check_model(service.engine, work.variant, work.terms)
        elif isinstance(work, DiagnosisWorkRequest):
            check_model(service.engine, work.base or work.variant)
        return None

    def busy(self) -> bool:
        """See Launcher."""
        return self._hardware().busy()

    def missing(self, work: AnyWorkRequest, *, surely: bool) -> str | None:
        """See Launcher."""
        if work.kind in ScheduledAnalyses.KINDS:
            return self._analyses.waits_for()
        resonator = work.request.mounted_resonator
        return None if resonator is None else self._hardware().not_mounted(resonator, surely=surely)

    def new_id(self, work: AnyWorkRequest) -> str:
        """See Launcher."""
        return new_identifier(work.kind, datetime.now(UTC))

    def stops(self) -> int:
        """See Launcher."""
        return self._hardware().stops

    def launch(self, work: AnyWorkRequest, job: str, stops: int) -> None:
        """See Launcher; what leaves the platform alone is not stopped."""
        if isinstance(work, FitWorkRequest | DiagnosisWorkRequest):
            self._analyses.queue(work, job)
        else:
            self._hardware().submit(work.kind, work.request, SubmitOptions(job, stops=stops))

    def outcome(self, job: str) -> JobOutcome:
        """See Launcher."""
        if not self._records.has(job):
            return JobOutcome("unknown")
        kind = job.partition("-")[0]
        try:
            analysis = kind in ScheduledAnalyses.KINDS
            found = self._analyses.shown(job) if analysis else self._hardware().job(kind, job)
        except InputError as error:
            return JobOutcome("failed", str(error))
        return _outcome(found)


def _outcome(found: JobView) -> JobOutcome:
    if not found.state.final:
        return JobOutcome("resting" if found.paused and found.state is JobState.QUEUED else "running")
    recording = getattr(found.result, "recording", None)
    if found.state is JobState.CANCELLED:
        if DAEMON_ENDED in found.record.warnings:
            return JobOutcome("failed", DAEMON_ENDED, recording)
        return JobOutcome("cancelled", recording=recording)
    reason = None if found.error is None else str(found.error)
    return JobOutcome("failed" if found.state is JobState.FAILED else "done", reason, recording)
