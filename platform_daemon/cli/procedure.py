"""What the commands of all procedures share: the plan, or the run and what it has brought."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from platform_daemon.reports import outcome_text, plan_text, steps_text

from .interrupts import INTERRUPTED
from .output import write_json
from .progress import interrupted_while, prepare_fit

if TYPE_CHECKING:
    from platform_daemon.engine import CharacterisationFiles, Engine, ProcedureWork
    from platform_daemon.schemas import AnyProcedureRequest, ProcedureResult

    Tell = Callable[[ProcedureResult], None]


def conduct(
    engine: Engine, request: AnyProcedureRequest, out: Path, json_file: Path | None, *, dry_run: bool,
    overwrite: bool, tell: Tell | None = None, tables: CharacterisationFiles | None = None,
) -> None:  # fmt: skip
    """Show the plan (`dry_run`), or run it into the recording `out` and say what came out, also of one cut short.

    tell: says in the end what it has found beside the results of its steps; tables: where a characterisation keeps
    what it makes.

    Raises InputError, what ended it, typer.Exit: 130 interrupted, 3 if no step gave a result.
    """
    from platform_daemon.engine import ProcedureFiles, plan_procedure

    log = out.with_name(f"{out.name}.log.json")
    files = ProcedureFiles(out.parent, out.parent, out, log, overwrite or dry_run)
    work = plan_procedure(engine, request, files, tables)
    if dry_run:
        print(plan_text(work.summary()))
        write_json(json_file, work.summary())
        return
    _run(engine, work, out, json_file, tell)


def _run(
    engine: Engine,
    work: ProcedureWork,
    out: Path,
    json_file: Path | None,
    tell: Tell | None,
) -> None:
    from platform_daemon.engine import NotTuned
    from platform_daemon.schemas import TuneOutcome

    prepare_fit()
    job = engine.submit(work)
    interrupted = interrupted_while(engine, job)
    result: ProcedureResult = job.result
    for warning in job.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    if result.steps:
        print(steps_text(result, work.summary()))
        if isinstance(result.outcome, TuneOutcome):
            print(outcome_text(result.outcome))
        print(f"{len(result.steps)} of {result.planned_steps} steps in {out}, log in {out}.log.json: {result.stopped}")
        write_json(json_file, work.record(job))
        if tell is not None:
            tell(result)
    if interrupted:
        raise typer.Exit(INTERRUPTED)
    if isinstance(job.error, NotTuned):
        print(f"error: {job.error}", file=sys.stderr)
        raise typer.Exit(3)
    if job.error is not None:
        raise job.error
    if not any(step.verdict == "good" for step in result.steps):
        print(f"no step can be used: {result.steps[0].reason}", file=sys.stderr)
        raise typer.Exit(3)
