"""What commands that run a procedure share: plan it, show the plan or run it, say what came out."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from platform_daemon.reports import plan_text, steps_text

from .interrupts import INTERRUPTED, heed_one_interrupt
from .options import library
from .output import must_not_exist, write_json
from .progress import interrupted_while, prepare_fit

if TYPE_CHECKING:
    from platform_daemon.engine import CharacterisationFiles, Engine, Job, ProcedureWork
    from platform_daemon.schemas import ProcedureRequest, ProcedureResult


@dataclass(frozen=True)
class Conducted:
    """How a procedure is run: platform file with overrides and addresses, adopted models, recording to write.

    dry_run: nothing moves; force: overwrite files that exist; plan_file: for the plan of a dry run.
    """

    platform: str
    overrides: list[str] | None
    endpoints: Path | None
    models: Path | None
    out: Path
    dry_run: bool
    force: bool
    plan_file: Path | None

    def run(
        self,
        request: ProcedureRequest,
        tell: Callable[[ProcedureWork, Job], None],
        tables: CharacterisationFiles | None = None,
    ) -> None:
        """Until it has ended; `tell` says what came out, also of one that was cut short.

        Raises InputError before anything moves, what ended it, typer.Exit: 130 interrupted, 3 if no step gave a result.
        """
        from platform_daemon.app import start_engine
        from platform_daemon.settings import load_platform

        must_not_exist(None if self.dry_run else self.out, self.force, ".h5", ".hdf5", ".mmr")
        heed_one_interrupt()
        platform = load_platform(self.platform, self.overrides or (), self.endpoints)
        engine = start_engine(platform, models=library(self.models))
        try:
            work = self._planned(engine, request, tables)
            if self.dry_run:
                print(plan_text(work.summary()))
                write_json(self.plan_file, work.summary())
            else:
                self._run(engine, work, tell)
        finally:
            engine.close()

    def _planned(
        self, engine: Engine, request: ProcedureRequest, tables: CharacterisationFiles | None
    ) -> ProcedureWork:
        from platform_daemon.engine import ProcedureFiles, plan_procedure

        log = self.out.with_name(f"{self.out.name}.log.json")
        files = ProcedureFiles(self.out.parent, self.out.parent, self.out, log, self.force or self.dry_run)
        return plan_procedure(engine, request, files, tables)

    def _run(self, engine: Engine, work: ProcedureWork, tell: Callable[[ProcedureWork, Job], None]) -> None:
        prepare_fit()
        job = engine.conduct(work)
        interrupted = interrupted_while(engine, job)
        result: ProcedureResult = job.result
        for warning in job.warnings:
            print(f"warning: {warning}", file=sys.stderr)
        if result.steps:
            print(steps_text(result, work.summary()))
            made = f"{len(result.steps)} of {result.planned_steps} steps"
            print(f"{made} in {self.out}, log in {self.out}.log.json: {result.stopped}")
            tell(work, job)
        if interrupted:
            raise typer.Exit(INTERRUPTED)
        if job.error is not None:
            raise job.error
        if not any(step.verdict == "good" for step in result.steps):
            print(f"no step can be used: {result.steps[0].reason}", file=sys.stderr)
            raise typer.Exit(3)
