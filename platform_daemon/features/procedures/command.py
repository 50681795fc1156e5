"""What the commands of all procedures share: print the plan, or run it and print the results."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.interrupts import INTERRUPTED
from platform_daemon.core.command_line.output import write_json
from platform_daemon.core.command_line.progress import interrupted_while, prepare_fit

from .report import plan_text, step_rows, steps_text

if TYPE_CHECKING:
    from platform_daemon.core.hardware.engine import Engine

    from .bench import ReportFiles
    from .conductor import ProcedureWork
    from .schema import AnyProcedureRequest, ProcedureResult

    Report = Callable[[ProcedureResult], None]


class NotMeasured(Exception):
    """No job ends with it: the default of `unusable`."""


def conduct(
    engine: Engine, request: AnyProcedureRequest, out: Path, json_file: Path | None, *, dry_run: bool,
    overwrite: bool, csv_file: Path | None = None, write: Report | None = None, found: Report | None = None,
    report: Report | None = None, reports: ReportFiles | None = None, unusable: type[Exception] = NotMeasured,
) -> None:  # fmt: skip
    """Show the plan (`dry_run`), or run it into the recording `out` and say what came out, also of one cut short.

    csv_file: for a row per step; write: writes files of its own, before anything is printed; found, report: show what
    the procedure has found apart from the results of its steps, before and after the line that names the files;
    reports: where a characterisation writes its report; unusable: an error of the job that means that nothing was
    found, exit code 3.

    Raises InputError, what ended it, typer.Exit: 130 interrupted, 3 if no step gave a result.
    """
    from platform_daemon.core.state.disk_space import check_room

    from .bench import ProcedureBench
    from .conductor import ProcedureFiles
    from .planned import plan_procedure

    log = out.with_name(f"{out.name}.log.json")
    files = ProcedureFiles(out.parent, out.parent, out, log, overwrite or dry_run)
    work = plan_procedure(ProcedureBench(engine=engine, files=files, reports=reports), request)
    if dry_run:
        write_json(json_file, work.summary())
        write_csv(csv_file, step_rows(work.summary().steps))
        print(plan_text(work.summary()))
        check_room(out.parent, work.summary().disk_bytes, work.summary().shots)
        return
    _run(engine, work, out, json_file, csv_file=csv_file, write=write, found=found, report=report, unusable=unusable)


def _run(
    engine: Engine,
    work: ProcedureWork,
    out: Path,
    json_file: Path | None,
    *,
    csv_file: Path | None,
    write: Report | None,
    found: Report | None,
    report: Report | None,
    unusable: type[Exception],
) -> None:
    prepare_fit()
    job = engine.submit(work)
    interrupted = interrupted_while(engine, job)
    result: ProcedureResult = job.result
    if result.steps:
        write_json(json_file, work.record(job))
        write_csv(csv_file, step_rows(result.steps))
        if write is not None:
            write(result)
    for warning in job.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    if result.steps:
        print(steps_text(result, work.summary()))
        if found is not None:
            found(result)
        print(f"{len(result.steps)} of {result.planned_steps} steps in {out}, log in {out}.log.json: {result.stopped}")
        if report is not None:
            report(result)
    if interrupted:
        raise typer.Exit(INTERRUPTED)
    if isinstance(job.error, unusable):
        print(f"error: {job.error}", file=sys.stderr)
        raise typer.Exit(3)
    if job.error is not None:
        raise job.error
    if not any(step.verdict == "good" for step in result.steps):
        print(f"no step can be used: {result.steps[0].reason}", file=sys.stderr)
        raise typer.Exit(3)
