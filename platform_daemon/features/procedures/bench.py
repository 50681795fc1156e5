"""What a procedure is planned with: what the `plan(bench, request)` of a kind of procedure is given."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.features.acquire.planning import AcquisitionPlan
from platform_daemon.features.acquire.series_plan import plan_series

from .conductor import ProcedureFiles, ProcedureWork
from .engine_steps import EngineSteps
from .procedure import Conclusion, OnlineFits, Procedure


@dataclass(frozen=True, kw_only=True)
class ReportFiles:
    """Where report and page of a procedure are kept: in `folder` as ID.json and ID.html of the job's id, or where
    `report` and `html` say; a file that neither says is not written."""

    folder: Path | None = None
    report: Path | None = None
    html: Path | None = None

    def named(self, job: str) -> tuple[Path | None, Path | None]:
        """(report, page) of the job of that id."""
        if self.folder is None:
            return self.report, self.html
        return self.folder / f"{job}.json", self.folder / f"{job}.html"


@dataclass(frozen=True, kw_only=True)
class ProcedureBench:
    """engine: owner of the platform; files: recording and log; reports: of a procedure that makes one, None: in the
    job's result alone."""

    engine: Engine
    files: ProcedureFiles
    reports: ReportFiles | None = None

    def plan_series(self, request: AcquisitionRequest) -> AcquisitionPlan:
        """The checked plan of a step.  Raises InputError."""
        return plan_series(self.engine, request)

    def work(self, procedure: Procedure, conclusion: Conclusion | None = None) -> ProcedureWork:
        """The work of a procedure, every known step checked.  Raises InputError that names the step."""
        return ProcedureWork(
            procedure, EngineSteps(self.engine), self.files, OnlineFits(self.engine.computing), conclusion
        )
