"""Scheduled works, started by the owner of the hardware like those that somebody asks for."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from secrets import token_hex

from drivers.errors import InputError
from platform_daemon.engine import DAEMON_ENDED, Asked, JobRecords
from platform_daemon.schedules import JobOutcome, Launcher
from platform_daemon.schemas import AnyWorkRequest, JobState

from .jobs import ShownJob
from .owner import OwnedHardware
from .scheduled_analyses import ScheduledAnalyses


class HardwareLauncher(Launcher):
    """See Launcher.  hardware: who owns it now, raises DeviceError while nobody does; records: of all jobs; recordings:
    their folder."""

    def __init__(self, hardware: Callable[[], OwnedHardware], records: JobRecords, recordings: Path) -> None:
        self._hardware, self._records = hardware, records
        self._analyses = ScheduledAnalyses(records, recordings)

    def planned_s(self, work: AnyWorkRequest) -> float | None:
        """See Launcher; of a self-test and of what is stored nobody knows."""
        match work.kind:
            case "acquisition":
                return self._hardware().dry_run(work.request).duration_s
            case "procedure":
                return self._hardware().dry_run_procedure(work.request).duration_s
            case "calibration":
                return self._hardware().calibration_takes_s(work.request)
            case "fit":
                self._hardware().check_model(work.variant, work.terms)
            case "diagnosis":
                self._hardware().check_model(work.base or work.variant)
            case "self_test":
                pass
        return None

    def busy(self) -> bool:
        """See Launcher."""
        return self._hardware().busy()

    def missing(self, work: AnyWorkRequest, *, surely: bool) -> str | None:
        """See Launcher."""
        if work.kind == "acquisition":
            return self._hardware().not_mounted(work.request.resonator, surely=surely)
        if work.kind == "procedure":
            return self._hardware().not_mounted(work.request.acquisition.resonator, surely=surely)
        return self._analyses.waits_for() if work.kind in ScheduledAnalyses.KINDS else None

    def new_id(self, work: AnyWorkRequest) -> str:
        """See Launcher."""
        return f"{work.kind}-{datetime.now(UTC):%Y%m%dT%H%M%S}-{token_hex(3)}"

    def stops(self) -> int:
        """See Launcher."""
        return self._hardware().stops

    def launch(self, work: AnyWorkRequest, job: str, stops: int) -> None:
        """See Launcher; what leaves the platform alone is not stopped."""
        asked = Asked(job, stops=stops)
        if work.kind == "fit" or work.kind == "diagnosis":
            self._analyses.queue(work, job)
        elif work.kind == "acquisition":
            self._hardware().acquire(work.request, asked)
        elif work.kind == "procedure":
            self._hardware().conduct(work.request, asked)
        elif work.kind == "self_test":
            self._hardware().self_test(work.request, asked)
        else:
            self._hardware().calibrate(work.request, asked)

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


def _outcome(found: ShownJob) -> JobOutcome:
    if not found.state.final:
        return JobOutcome("resting" if found.paused and found.state is JobState.QUEUED else "running")
    recording = getattr(found.result, "recording", None)
    if found.state is JobState.CANCELLED:
        if DAEMON_ENDED in found.record.warnings:
            return JobOutcome("failed", DAEMON_ENDED, recording)
        return JobOutcome("cancelled", recording=recording)
    reason = None if found.error is None else str(found.error)
    return JobOutcome("failed" if found.state is JobState.FAILED else "done", reason, recording)
