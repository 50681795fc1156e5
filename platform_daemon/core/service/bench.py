"""What the work of a job is planned with: what a feature's `plan(bench, request)` is given."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.jobs import AnyJob
from platform_daemon.core.jobs.workers.task_executor import TaskExecutor
from platform_daemon.core.recordings.data_folder import DataFolder
from platform_daemon.core.schemas.requests import SHIPPED_PRESET, TUNED_PRESET, AcquisitionRequest
from platform_daemon.core.state.disk_space import check_free_space


@dataclass(frozen=True, kw_only=True)
class Folders:
    """Where the hardware process writes."""

    recordings: Path
    procedures: Path
    characterisations: Path
    reproductions: Path
    calibrations: Path
    mounted: Path


@dataclass(frozen=True, kw_only=True)
class HardwareBench:
    """For jobs that need the hardware.

    Attributes:
        engine: owner of the platform.
        folders: where results go.
        again: the job of an earlier run whose work is planned again, None: a new one.
        resumes: the missing shots go into the recording that `again` has left.
    """

    engine: Engine
    folders: Folders
    again: AnyJob | None = None
    resumes: bool = False

    def check_named(self, request: AcquisitionRequest) -> None:
        """Raises InputError unless the catalogue has resonator and preset by name: no path is taken by REST."""
        self.engine.catalogue.resonators.named(request.resonator)
        if request.preset not in (None, SHIPPED_PRESET, TUNED_PRESET):
            self.engine.catalogue.sequences.named(request.preset)

    def check_feasible(self, disk_bytes: int, shots: int) -> None:
        """Raises StorageUnusable without room for so many bytes and shots; InterlockError if the platform is set so
        that no power may come, as with a lease that is too long.  A job of an earlier run was checked then."""
        if self.again is not None:
            return
        check_free_space(self.folders.recordings, disk_bytes, shots)
        unfit = self.engine.platform.guard.unfit()
        if unfit is not None:
            raise unfit


@dataclass(frozen=True, kw_only=True)
class AnalysisBench:
    """For jobs on stored recordings: `executor` runs their tasks, `folders` are those of the daemon's data."""

    executor: TaskExecutor
    folders: DataFolder
