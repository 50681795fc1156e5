"""Scheduled works, started on the owner of the hardware like those that somebody asks for."""

from __future__ import annotations

from collections.abc import Callable

from drivers.errors import InputError
from platform_daemon.engine import DAEMON_ENDED
from platform_daemon.schedules import JobOutcome, Launcher
from platform_daemon.schemas import AnyWorkRequest, JobState

from .hardware import Hardware


class HardwareLauncher(Launcher):
    """See Launcher.  hardware: who answers now; raises DeviceError while nobody does."""

    def __init__(self, hardware: Callable[[], Hardware]) -> None:
        self._hardware = hardware

    def planned_s(self, work: AnyWorkRequest) -> float | None:
        """See Launcher; of a calibration nobody knows."""
        if work.kind == "acquisition":
            return self._hardware().dry_run(work.request).duration_s
        if work.kind == "procedure":
            return self._hardware().dry_run_procedure(work.request).duration_s
        return None

    def busy(self) -> bool:
        """See Launcher."""
        status = self._hardware().status()
        return status.running is not None or bool(status.queued)

    def launch(self, work: AnyWorkRequest) -> str:
        """See Launcher."""
        hardware = self._hardware()
        if work.kind == "acquisition":
            return hardware.acquire(work.request).identifier
        if work.kind == "procedure":
            return hardware.conduct(work.request).identifier
        return hardware.calibrate(work.request).identifier

    def outcome(self, job: str) -> JobOutcome:
        """See Launcher."""
        try:
            found = self._hardware().job(job.partition("-")[0], job)
        except InputError as error:
            return JobOutcome("failed", str(error))
        if not found.state.final:
            return JobOutcome("running")
        recording = getattr(found.result, "recording", None)
        if found.state is JobState.CANCELLED:
            if DAEMON_ENDED in found.record.warnings:
                return JobOutcome("failed", DAEMON_ENDED, recording)
            return JobOutcome("cancelled", recording=recording)
        reason = None if found.error is None else str(found.error)
        return JobOutcome("failed" if found.state is JobState.FAILED else "done", reason, recording)
