"""From what is asked over the network to work that is checked; nothing moves."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from platform_daemon import reports  # not its parts: they load matplotlib when they are first used
from platform_daemon.engine import (
    AcquisitionPlan,
    CharacterisationFiles,
    Engine,
    ProcedureFiles,
    ProcedureWork,
    Work,
    plan_calibration,
    plan_procedure,
    plan_self_test,
    series_work,
)
from platform_daemon.schemas import (
    AcquisitionRequest,
    AnyProcedureRequest,
    AnyQueuedRequest,
    CalibrationRequest,
    SelfTestRequest,
)
from platform_daemon.store import check_room
from platform_daemon.workers import WorkerLimits, in_time

from .feasible import check_feasible


@dataclass(frozen=True)
class Folders:
    """Where the owner of the hardware writes."""

    recordings: Path
    procedures: Path
    characterisations: Path
    calibrations: Path
    mounted: Path


class Plans:
    """Each raises InputError for what cannot be, StorageUnusable and InterlockError as `check_feasible`.

    limits: how long what is asked for may be planned; what was found feasible once is not asked for again.
    """

    def __init__(self, engine: Engine, folders: Folders, limits: WorkerLimits) -> None:
        self._engine, self._folders = engine, folders
        self._bounds = limits.of("planning")

    def only_named(self, resonator: str) -> None:
        """Raises InputError for a path: over the network none is given as one."""
        self._engine.catalogue.resonators.named(resonator)

    def series(self, request: AcquisitionRequest) -> AcquisitionPlan:
        """Of a series."""
        self.only_named(request.resonator)
        with in_time("planning", self._bounds):
            plan = self._engine.plan(request)
        check_feasible(self._engine, self._folders.recordings, plan.disk_bytes, plan.shots_in_all)
        return plan

    def procedure(self, request: AnyProcedureRequest) -> ProcedureWork:
        """Of a procedure."""
        with in_time("planning", self._bounds):
            work = self.known_procedure(request)
        summary = work.summary()
        check_feasible(self._engine, self._folders.recordings, summary.disk_bytes, summary.shots)
        return work

    def known_procedure(self, request: AnyProcedureRequest) -> ProcedureWork:
        """Of one that was found feasible once."""
        self.only_named(request.acquisition.resonator)
        files = ProcedureFiles(self._folders.recordings, self._folders.procedures)
        tables = CharacterisationFiles(reports.characterisation_html, self._folders.characterisations)
        return plan_procedure(self._engine, request, files, tables)

    def work(self, request: AnyQueuedRequest) -> Work[Any, Any]:
        """Of whatever can be queued."""
        match request:
            case AcquisitionRequest():
                return series_work(self._engine, self.series(request), self._folders.recordings)
            case CalibrationRequest():
                check_room(self._folders.calibrations, 0)  # a file of some kB: what it costs is the shots before it
                return plan_calibration(self._engine, request, self._folders.calibrations)
            case SelfTestRequest():
                return plan_self_test(self._engine, request)
        return self.procedure(request)
