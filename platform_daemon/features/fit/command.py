"""`platform-daemon fit`: one or many recordings, on all cores or on a cluster."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.interrupts import end_at_once, heed_one_interrupt
from platform_daemon.core.command_line.options import (
    CalibrationOption,
    FixOption,
    FramesOption,
    ModelsOption,
    StepOrAllOption,
    TableOptions,
    TermOption,
    VariantOption,
    WindowOption,
    calibration_in,
)
from platform_daemon.core.command_line.output import must_not_exist
from platform_daemon.core.command_line.request_options import option_groups
from platform_daemon.features.models.options import variant_named


@dataclass(frozen=True, kw_only=True)
class HeldOptions:
    """What the fit holds at given values."""

    fix: FixOption = None
    hint: Annotated[
        list[str] | None, typer.Option("--hint", help="Hold the loss NAME=VALUE where the window cannot determine it.")
    ] = None


@dataclass(frozen=True, kw_only=True)
class BatchOptions:
    """Where many files are fitted, and what is known of a run before."""

    jsonl: Annotated[Path | None, typer.Option("--jsonl", help="Append each finished file as a line.")] = None
    resume: Annotated[bool, typer.Option("--resume", help="Leave out files that --jsonl holds already.")] = False
    processes: Annotated[int | None, typer.Option(min=1, help="Processes; default: one per core.")] = None
    dask: Annotated[str | None, typer.Option("--dask", metavar="ADDRESS", help="Fit on this Dask cluster.")] = None

    def check(self, force: bool) -> None:
        """Raises InputError if --jsonl and --resume do not go together with the files that exist."""
        if self.resume and self.jsonl is None:
            remedy = "name the file of the last run with --jsonl"
            raise InputError("nothing to go on from", where="--resume", remedy=remedy)
        must_not_exist(self.jsonl, force or self.resume, ".jsonl")


@option_groups
def fit(
    *,
    files: Annotated[list[Path], typer.Argument(help="Recordings.")],
    variant: VariantOption = None,
    term: TermOption = None,
    models: ModelsOption = None,
    window: WindowOption = "d30",
    calibration: CalibrationOption = None,
    frames: FramesOption = None,
    step: StepOrAllOption = None,
    held: HeldOptions,
    derived: Annotated[
        bool, typer.Option("--derived", help="Add Q, equivalent Q, orientation errors, Allan deviation.")
    ] = False,
    result: TableOptions,
    batch: BatchOptions,
) -> None:
    """Fit the frames of one or more recordings."""
    from platform_daemon.core.command_line.parsing import parse_frames, parse_values, parse_window
    from platform_daemon.core.command_line.progress import compile_fit
    from platform_daemon.features.fit.fit_files import (
        FitResults,
        batch_workers,
        fit_all,
        ledger_of,
        report_interrupt,
        report_results,
    )

    from .fit_request import FitSettings

    settings = FitSettings(
        calibration=calibration_in(calibration),
        fixed=parse_values(held.fix or [], "--fix"),
        hold_if_inseparable=parse_values(held.hint or [], "--hint"),
        model=variant_named(variant, models),
        window=parse_window(window),
        derived=derived,
        terms=tuple(term or ()),
        frames=None if frames is None else parse_frames(frames),
        step=step,
    )
    result.check()
    batch.check(result.force)
    heed_one_interrupt()
    with ExitStack() as stack:  # left by end_at_once without its clean-up, which may wait for ever for the processes
        results = FitResults(files, stack.enter_context(ledger_of(batch.jsonl, settings, resume=batch.resume)))
        try:
            if results.todo:
                if batch.dask is None:
                    compile_fit()  # once, before every process would
                workers = stack.enter_context(
                    batch_workers(results.todo, settings, processes=batch.processes, dask=batch.dask)
                )
                fit_all(results, settings, workers)
        except KeyboardInterrupt:
            report_interrupt(results, result)
            end_at_once()
    report_results(results, result)
